// headframe: the operator's command. Talks to headframe-server over HTTP.

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "server/cli/commands.hpp"
#include "server/cli/completion.hpp"
#include "server/cli/date.hpp"
#include "server/cli/table.hpp"
#include "server/cli/token.hpp"
#include "server/cli/trust.hpp"

namespace {

using headframe::Commands;
using headframe::Result;

struct Options {
  std::string http = "127.0.0.1:7448", token_file, fingerprint, authorities;
  bool json = false;
  std::optional<double> wait_s;
  std::optional<std::string> note;
  double every_s = 1;
  int times = 0, most = 10000, rejected = 1000, mib = 0;
  std::vector<double> at;
  headframe::MapRequest map;
  std::string person, role = "operate";
  double days = 30;
  std::string session, file, frame, label, reason, robot, alignment, a, b, shell = "bash";
  std::int64_t kib_s = 0;
  double since_s = 0;
  bool all_the_same = false;
  std::function<Result<int>(Commands&)> command;
};

/// Adds subcommands to `app`: each has --json, and sets what is to be run.
auto adder(CLI::App& app, Options& options) {
  return [&app, &options](const char* name, const char* what, auto run) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_flag("--json", options.json, "Print JSON");
    sub->callback([&options, run] { options.command = run; });
    return sub;
  };
}

void add_commands(CLI::App& app, Options& options) {
  const auto add = adder(app, options);
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
  add("completion", "A script: source <(headframe completion bash), or zsh; headframe completion fish | source",
      [&](Commands&) -> Result<int> {
        std::cout << headframe::completion(app, options.shell);
        return headframe::exit_ok;
      })
      ->add_option("SHELL", options.shell, "bash (default), zsh or fish")
      ->check(CLI::IsMember(
          std::vector<std::string>(headframe::completed_shells.begin(), headframe::completed_shells.end())));
  add("changes", "What changed in the mine between sessions that are merged, the newest first",
      [&](Commands& c) { return c.changes(options.since_s); })
      ->add_option_function<std::string>(
          "--since", [&](const std::string& date) { options.since_s = *headframe::seconds_of(date); },
          "What may have come after this day (UTC)")
      ->type_name("YYYY-MM-DD")
      ->check([](const std::string& date) {
        return headframe::seconds_of(date) ? std::string() : date + " is no date; write YYYY-MM-DD, as in 2026-11-23";
      });
  wait(add("merge", "Try to merge every session now, and wait for the outcome",
           [&](Commands& c) { return c.merge(options.wait_s); }),
       "Wait no longer than this; exit status 3 when work is still pending");
}

void add_pair_commands(CLI::App& app, Options& options) {
  const auto add = adder(app, options);
  add("alignments", "Every alignment with its evidence", [&](Commands& c) { return c.alignments(options.rejected); })
      ->add_option("--most", options.rejected, "Of pairs that came to nothing, the newest (default 1000)")
      ->check(CLI::Range(0, 1000000));
  const auto decision = [&](const char* name, const char* what) {
    CLI::App* sub = add(
        name, what, [&options, name](Commands& c) { return c.decide(name, options.alignment, options.all_the_same); });
    sub->add_option("ALIGNMENT", options.alignment, "Its number, as alignments shows it")->required();
    return sub;
  };
  decision("confirm", "Publish an alignment whatever its evidence says, and keep it")
      ->add_flag("--yes", options.all_the_same, "Also one that other sessions contradict, or that is improbable");
  decision("refuse", "Do not propose this placement again on much the same evidence");
  decision("retract", "Take a published alignment out; the robots are told");
  decision("undo", "Take back the latest decision on an alignment");
  CLI::App* why = add("explain", "Why two sessions are or are not merged",
                      [&](Commands& c) { return c.explain(options.a, options.b); });
  why->add_option("A", options.a, "robot/session, or robot when it has just one")->required();
  why->add_option("B", options.b, "The other")->required();
  CLI::App* place = add("place", "Lay session B on A by hand: registration refines it, and it waits for confirm",
                        [&](Commands& c) { return c.place(options.a, options.b, options.at, options.file); });
  place->add_option("A", options.a, "robot/session, or robot when it has just one")->required();
  place->add_option("B", options.b, "The other")->required();
  place->add_option("--at", options.at, "Where B's origin lies in A, in metres, and how B is turned, in degrees")
      ->expected(4)
      ->type_name("X Y Z YAW");
  place->add_option("--pairs", options.file, "Three spots or more, a line each: x y z in A, then x y z in B")
      ->type_name("FILE");
}

constexpr const char* session_help = "robot/session, or the robot or the label when just one has it";

void add_frame(CLI::App* sub, std::string& frame) {
  sub->add_option("--frame", frame, "component (default) or grid: the mine's, known by a survey")
      ->check(CLI::IsMember({"component", "grid"}));
}

void add_export_commands(CLI::App& app, Options& options) {
  const auto add = adder(app, options);
  CLI::App* map = add("export", "The merged cloud of a component, or its plan",
                      [&](Commands& c) { return c.export_map(options.map); });
  map->add_option("--component", options.map.component,
                  "Id of the component, as atlas shows it; or any session of it: robot/session, robot or label")
      ->required()
      ->type_name("ID|SESSION");
  map->add_option("--voxel", options.map.voxel_m,
                  "One point per cube within each keyframe, 0: every point (default 0.1)")
      ->check(CLI::Range(0.0, 100.0))
      ->type_name("M");
  map->add_option("--format", options.map.format,
                  "ply, pcd or las: the points; pdf, svg or png: the plan; default: FILE's ending")
      ->check(CLI::IsMember({"ply", "pcd", "las", "pdf", "svg", "png"}));
  map->add_option("--scale", options.map.scale, "Of a plan, 1:N; default: the largest that fits A3")
      ->check(CLI::Range(50, 100000))
      ->type_name("N");
  add_frame(map, options.map.frame);
  map->add_option("FILE", options.map.file, "FILE.ply, FILE.pcd or FILE.las; FILE.pdf, FILE.svg or FILE.png: the plan")
      ->required();
  CLI::App* path = add("trajectory", "A session's trajectory, as TUM text or CSV",
                       [&](Commands& c) { return c.trajectory(options.session, options.file, options.frame); });
  add_frame(path, options.frame);
  path->add_option("SESSION", options.session, session_help)->required();
  path->add_option("FILE", options.file, "Where to write it; CSV when it ends in .csv")->required();
  add("backup", "All of the base station as one file, while it runs; headframe-server --restore takes it",
      [&](Commands& c) { return c.backup(options.file); })
      ->add_option("FILE", options.file, "Where to write it; nobody else may read it")
      ->required();
}

void add_store_commands(CLI::App& app, Options& options) {
  CLI::App* store = app.add_subcommand("store", "How much room there is for what robots send");
  store->add_flag("--json", options.json, "Print JSON");
  const auto add_store = adder(*store, options);
  add_store("show", "How much is free, and which clouds would go for more", [](Commands& c) { return c.store(); });
  CLI::App* let_go = add_store("let-go", "Delete clouds of rock that later sessions keep, the oldest first, for good",
                               [&](Commands& c) { return c.let_go(options.mib, options.all_the_same); });
  let_go->add_option("--mib", options.mib, "As many as free so much; default: all that may go")
      ->check(CLI::Range(1, 1000000000));
  let_go->add_flag("--yes", options.all_the_same, "Do it; without, only what would go is said");
}

void add_session_commands(CLI::App& app, Options& options) {
  const auto add = adder(app, options);
  const auto of_session = [&](CLI::App* sub) {
    sub->add_option("SESSION", options.session, session_help)->required();
    return sub;
  };
  of_session(add("rename", "Give a session a label; an empty one takes it away",
                 [&](Commands& c) { return c.rename(options.session, options.label); }))
      ->add_option("LABEL", options.label, "At most 128 bytes")
      ->required();
  of_session(add("anchor", "Make a session's frame that of its component; the robots are told",
                 [&](Commands& c) { return c.anchor(options.session); }));
  of_session(add("request-clouds", "Ask a session's robot for the clouds that are not here",
                 [&](Commands& c) { return c.request_clouds(options.session); }));
  CLI::App* overlay = add("overlay", "How far the surfaces of two aligned sessions lie apart; with --json their points",
                          [&](Commands& c) { return c.overlay(options.alignment, options.most); });
  overlay->add_option("ALIGNMENT", options.alignment, "Its number, as alignments shows it")->required();
  overlay->add_option("--most", options.most, "Points of each session (default 10000)")->check(CLI::Range(0, 100000));
  CLI::App* session = app.add_subcommand("session", "What becomes of a session over the years, or when it does harm");
  session->add_flag("--json", options.json, "Print JSON");
  const auto add_fate = adder(*session, options);
  of_session(add_fate("quarantine", "Leave a session out of merging; what is stored of it stays", [&](Commands& c) {
    return c.quarantine(options.session, options.reason);
  }))->add_option("--reason", options.reason, "Why: shown beside the session");
  of_session(add_fate("release", "Merge a session again that was set aside",
                      [&](Commands& c) { return c.release(options.session); }));
  const auto tend = [&](const char* action, const char* what, const char* done) {
    of_session(
        add_fate(action, what, [&, action, done](Commands& c) { return c.tend(options.session, action, done); }));
  };
  tend("archive", "Keep a session, and leave it out of everything until it is restored",
       " is archived; session restore brings it back");
  tend("restore", "Bring a session back that was archived, as it was", " is back");
  tend("freeze", "Make a session reference: nothing moves it any more, others are aligned to it",
       " is frozen; session thaw lets it move again");
  tend("thaw", "Let a session be moved again that was frozen", " may move again");
  of_session(add_fate("note", "Write down what is to be remembered of a session; without TEXT, show it",
                      [&](Commands& c) { return c.note(options.session, options.note); }))
      ->add_option("TEXT", options.note, "At most 2000 bytes; empty: take the note away");
  of_session(add_fate("delete", "Delete all that is stored of a session, for good", [&](Commands& c) {
    return c.remove_session(options.session, options.all_the_same);
  }))->add_flag("--yes", options.all_the_same, "Do it; without, only what hangs on it is said");
  CLI::App* survey = app.add_subcommand("survey", "Where sessions lie in the mine's grid");
  survey->add_flag("--json", options.json, "Print JSON");
  const auto add_survey = adder(*survey, options);
  add_survey("list", "All surveys, and how far each control point is off",
             [](Commands& c) { return c.list_surveys(); });
  CLI::App* set = of_session(add_survey("set", "Set a session's survey", [&](Commands& c) {
    return c.set_survey(options.session, options.file, options.all_the_same);
  }));
  set->add_option("FILE", options.file,
                  "Control points, FILE.csv: name, x, y, z of the session, east, north, height of the grid, between "
                  "commas, semicolons, tabs or blanks; or JSON")
      ->required();
  set->add_flag("--accept", options.all_the_same, "Also when the points do not fit each other as well as they should");
  of_session(
      add_survey("drop", "Take a session's survey away", [&](Commands& c) { return c.drop_survey(options.session); }));
}

void add_robot_commands(CLI::App& app, Options& options) {
  CLI::App* robots = app.add_subcommand("robot", "Which robots may come in");
  robots->add_flag("--json", options.json, "Print JSON");
  const auto add = adder(*robots, options);
  add("list", "All robots, and the server's fingerprint", [](Commands& c) { return c.list_robots(); });
  const auto named = [&](CLI::App* sub) { sub->add_option("NAME", options.robot, "Of the robot")->required(); };
  named(add("add", "Print what a robot needs to enrol, once", [&](Commands& c) { return c.add_robot(options.robot); }));
  const auto rate = add("rate", "What the robot may send at most, from now on", [&](Commands& c) {
    return c.rate_robot(options.robot, static_cast<std::uint64_t>(options.kib_s));
  });
  named(rate);
  rate->add_option("KIB_S", options.kib_s, "KiB per second; 0: no limit of its own")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1000000000}))
      ->required();
  named(add("revoke", "Cut a robot off, now and until it enrols anew",
            [&](Commands& c) { return c.revoke_robot(options.robot); }));
}

void add_operator_commands(CLI::App& app, Options& options) {
  CLI::App* people = app.add_subcommand("operator", "Who may work with this server beside you, and as what");
  people->add_flag("--json", options.json, "Print JSON");
  const auto add = adder(*people, options);
  add("list", "All operators with a name", [](Commands& c) { return c.list_operators(); });
  const auto named = [&](CLI::App* sub) {
    sub->add_option("NAME", options.person, "Of the operator")->required();
    return sub;
  };
  CLI::App* one = named(add("add", "Print a token for an operator; an earlier one of the same name ends",
                            [&](Commands& c) { return c.add_operator(options.person, options.role, options.days); }));
  one->add_option("--role", options.role, "view, operate (default) or administer")
      ->check(CLI::IsMember({"view", "operate", "administer"}));
  one->add_option("--days", options.days, "How long the token is good for (default 30)")
      ->check(CLI::Range(0.001, 3650.0));
  named(add("revoke", "End an operator's token, now", [&](Commands& c) { return c.revoke_operator(options.person); }));
}

int fault(const headframe::Error& error) {
  std::cerr << "headframe: " << headframe::printable(error.message) << '\n';
  return error.code == headframe::ErrorCode::invalid_argument ? headframe::exit_usage : headframe::exit_failed;
}

/// Of a command that has commands of its own, and of the program itself.
headframe::Error nothing_said(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  const CLI::App& at = chosen.empty() ? app : *chosen.front();
  std::string there;
  for (const CLI::App* sub : at.get_subcommands([](const CLI::App*) { return true; }))
    there += (there.empty() ? "" : ", ") + sub->get_name();
  const std::string name = chosen.empty() ? "headframe" : "headframe " + at.get_name();
  return {headframe::ErrorCode::invalid_argument,
          "say what to do: " + name + " has " + there + "; " + name + " --help tells more"};
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("The operator's command of headframe: what the base station knows, and the merged map.", "headframe");
  app.add_option("--http", options.http,
                 "Where headframe-server answers operators. Without https:// or http://: HTTPS, but on the loopback")
      ->capture_default_str()
      ->type_name("[https://]HOST:PORT");
  app.add_option("--fingerprint", options.fingerprint,
                 "Of the server's certificate, as headframe-server prints it: HTTPS with that server alone")
      ->envname("HEADFRAME_FINGERPRINT")
      ->type_name("HEX");
  app.add_option("--ca", options.authorities,
                 "PEM file of who vouches for the server's certificate; default: whom this machine trusts")
      ->envname("HEADFRAME_CA")
      ->type_name("FILE");
  app.add_option("--token-file", options.token_file,
                 "The server's DATA/operator.token. Without it: $HEADFRAME_TOKEN, or headframe-data/operator.token")
      ->envname("HEADFRAME_TOKEN_FILE")
      ->type_name("FILE");
  app.add_flag("--json", options.json, "Print JSON");
  app.set_version_flag("--version", "headframe " HEADFRAME_VERSION);
  app.require_subcommand(0, 1);  // of 1, a misspelt one would be called a missing one
  app.fallthrough();
  add_commands(app, options);
  add_pair_commands(app, options);
  add_export_commands(app, options);
  add_session_commands(app, options);
  add_store_commands(app, options);
  add_robot_commands(app, options);
  add_operator_commands(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "headframe: " << headframe::printable(error.what()) << "; headframe --help lists what there is\n";
    return headframe::exit_usage;
  }
  if (!options.command) return fault(nothing_said(app));
  auto endpoint = headframe::parse_http_endpoint(options.http);
  if (!endpoint) return fault({endpoint.error().code, "--http: " + endpoint.error().message});
  auto token = headframe::find_token(options.token_file);
  if (!token) return fault(token.error());
  endpoint->token = *token;
  auto trust = headframe::find_trust(options.fingerprint, options.authorities, options.token_file);
  if (!trust) return fault(trust.error());
  endpoint->trust = *trust;
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
