// headframe: the operator's command. Talks to headframe-server over HTTP.

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "server/cli/commands.hpp"
#include "server/cli/table.hpp"
#include "server/cli/token.hpp"

namespace {

using headframe::Commands;
using headframe::Result;

struct Options {
  std::string http = "127.0.0.1:7448", token_file;
  bool json = false;
  std::optional<double> wait_s, voxel_m;
  double every_s = 1;
  int times = 0;
  std::string component, session, file, robot, alignment, a, b;
  std::uint64_t kib_s = 0;
  std::function<Result<int>(Commands&)> command;
};

/// Completes subcommands, then the options of the one that was given, then files.
std::string completion(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    std::string options;
    for (const CLI::Option* option : sub->get_options())
      for (const std::string& name : option->get_lnames()) options += (options.empty() ? "--" : " --") + name;
    commands += (commands.empty() ? "" : " ") + sub->get_name();
    cases += "      " + sub->get_name() + ") words=\"" + options + "\" ;;\n";
  }
  return "_headframe() {\n  local word words=\"" + commands + " --http --json --help\"\n" +
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n    case \"$word\" in\n" + cases +
         "    esac\n  done\n  COMPREPLY=($(compgen -W \"$words\" -- \"${COMP_WORDS[COMP_CWORD]}\"))\n}\n"
         "complete -o default -F _headframe headframe\n";
}

void add_commands(CLI::App& app, Options& options) {
  const auto add = [&](const char* name, const char* what, auto run) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_flag("--json", options.json, "Print JSON");
    sub->callback([&options, run] { options.command = run; });
    return sub;
  };
  const auto wait = [&](CLI::App* sub, const char* what) {
    sub->add_option("--wait", options.wait_s, what)->check(CLI::Range(0.0, 1e7))->type_name("SECONDS");
  };
  add("status", "What the server is doing", [](Commands& c) { return c.status(); });
  add("sessions", "Sessions of all robots", [](Commands& c) { return c.sessions(); });
  wait(add("atlas", "Which sessions are merged, where, and on what evidence",
           [&](Commands& c) { return c.atlas(options.wait_s); }),
       "Wait until no merge work is pending; exit status 3 when it still is");
  CLI::App* watch = add("watch", "Status and sessions, shown again and again",
                        [&](Commands& c) { return c.watch(options.every_s, options.times); });
  watch->add_option("--every", options.every_s, "Between two looks (default 1)")
      ->check(CLI::Range(0.01, 3600.0))
      ->type_name("SECONDS");
  watch->add_option("--times", options.times, "End after so many looks")->check(CLI::Range(1, 1000000));
  add("completion", "A script for bash: source <(headframe completion)", [&app](Commands&) -> Result<int> {
    std::cout << completion(app);
    return headframe::exit_ok;
  });
  add("alignments", "Every alignment with its evidence", [](Commands& c) { return c.alignments(); });
  const auto decision = [&](const char* name, const char* what) {
    add(name, what, [&options, name](Commands& c) { return c.decide(name, options.alignment); })
        ->add_option("ALIGNMENT", options.alignment, "Its number, as alignments shows it")
        ->required();
  };
  decision("confirm", "Publish an alignment whatever its evidence says, and keep it");
  decision("refuse", "Do not propose this placement again on much the same evidence");
  decision("retract", "Take a published alignment out; the robots are told");
  decision("undo", "Take back the latest decision on an alignment");
  CLI::App* why = add("explain", "Why two sessions are or are not merged",
                      [&](Commands& c) { return c.explain(options.a, options.b); });
  why->add_option("A", options.a, "robot/session, or robot when it has just one")->required();
  why->add_option("B", options.b, "The other")->required();
  wait(add("merge", "Try to merge every session now, and wait for the outcome",
           [&](Commands& c) { return c.merge(options.wait_s); }),
       "Wait no longer than this; exit status 3 when work is still pending");
  CLI::App* map = add("export", "The merged cloud of a component",
                      [&](Commands& c) { return c.export_map(options.component, options.file, options.voxel_m); });
  map->add_option("--component", options.component, "Id of the component, as atlas shows it")
      ->required()
      ->type_name("ID");
  map->add_option("--voxel", options.voxel_m, "One point per cube within each keyframe, 0: every point (default 0.1)")
      ->check(CLI::Range(0.0, 100.0))
      ->type_name("M");
  map->add_option("FILE", options.file, "FILE.ply, FILE.pcd or FILE.las")->required();
  CLI::App* path = add("trajectory", "A session's trajectory in its component's frame, as TUM text",
                       [&](Commands& c) { return c.trajectory(options.session, options.file); });
  path->add_option("SESSION", options.session, "robot/session, or robot when it has just one")->required();
  path->add_option("FILE", options.file, "Where to write it")->required();
}

void add_robot_commands(CLI::App& app, Options& options) {
  CLI::App* robots = app.add_subcommand("robot", "Which robots may come in");
  robots->add_flag("--json", options.json, "Print JSON");
  const auto add = [&](const char* name, const char* what, auto run) {
    CLI::App* sub = robots->add_subcommand(name, what);
    sub->add_flag("--json", options.json, "Print JSON");
    sub->callback([&options, run] { options.command = run; });
    return sub;
  };
  add("list", "All robots, and the server's fingerprint", [](Commands& c) { return c.list_robots(); });
  const auto named = [&](CLI::App* sub) { sub->add_option("NAME", options.robot, "Of the robot")->required(); };
  named(add("add", "Print what a robot needs to enrol, once", [&](Commands& c) { return c.add_robot(options.robot); }));
  const auto rate = add("rate", "What the robot may send at most, from now on",
                        [&](Commands& c) { return c.rate_robot(options.robot, options.kib_s); });
  named(rate);
  rate->add_option("KIB_S", options.kib_s, "KiB per second; 0: no limit of its own")->required();
  named(add("revoke", "Cut a robot off, now and until it enrols anew",
            [&](Commands& c) { return c.revoke_robot(options.robot); }));
}

int fault(const headframe::Error& error) {
  std::cerr << "headframe: " << headframe::printable(error.message) << '\n';
  return error.code == headframe::ErrorCode::invalid_argument ? headframe::exit_usage : headframe::exit_failed;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("The operator's command of headframe: what the base station knows, and the merged map.", "headframe");
  app.add_option("--http", options.http, "Where headframe-server answers HTTP")
      ->capture_default_str()
      ->type_name("HOST:PORT");
  app.add_option("--token-file", options.token_file,
                 "The server's DATA/operator.token. Without it: $HEADFRAME_TOKEN, or headframe-data/operator.token")
      ->envname("HEADFRAME_TOKEN_FILE")
      ->type_name("FILE");
  app.add_flag("--json", options.json, "Print JSON");
  app.require_subcommand(0, 1);  // of 1, a misspelt one would be called a missing one
  app.fallthrough();
  add_commands(app, options);
  add_robot_commands(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "headframe: " << headframe::printable(error.what()) << "; headframe --help lists what there is\n";
    return headframe::exit_usage;
  }
  if (!options.command)
    return fault({headframe::ErrorCode::invalid_argument,
                  "say what to do: status, sessions, atlas, merge, confirm, export or robot, say; headframe --help "
                  "lists what there is"});
  auto endpoint = headframe::parse_http_endpoint(options.http);
  if (!endpoint) return fault({endpoint.error().code, "--http: " + endpoint.error().message});
  auto token = headframe::find_token(options.token_file);
  if (!token) return fault(token.error());
  endpoint->token = *token;
  Commands commands(*endpoint, options.json);
  const auto code = options.command(commands);
  return code ? *code : fault(code.error());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const nlohmann::json::exception&) {
    return fault(
        {headframe::ErrorCode::bad_input, "the answer is not the JSON of headframe-server; is it another one?"});
  } catch (const std::exception& exception) {
    return fault({headframe::ErrorCode::internal, exception.what()});
  }
}
