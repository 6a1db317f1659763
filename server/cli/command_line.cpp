// Commands that look at what the server knows, decide on pairs, and take something home.
#include <iostream>

#include "server/cli/command_line.hpp"
#include "server/cli/completion.hpp"
#include "server/cli/date.hpp"

namespace headframe {
namespace {

void add_frame(CLI::App* sub, std::string& frame) {
  sub->add_option("--frame", frame, "component (default) or grid: the mine's, known by a survey")
      ->check(CLI::IsMember({"component", "grid"}));
}

}  // namespace

void add_look_commands(CLI::App& app, Options& options) {
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
        std::cout << completion(app, options.shell);
        return exit_ok;
      })
      ->add_option("SHELL", options.shell, "bash (default), zsh or fish")
      ->check(CLI::IsMember(std::vector<std::string>(completed_shells.begin(), completed_shells.end())));
  add("changes", "What changed in the mine between sessions that are merged, the newest first",
      [&](Commands& c) { return c.changes(options.since_s); })
      ->add_option_function<std::string>(
          "--since", [&](const std::string& date) { options.since_s = *seconds_of(date); },
          "What may have come after this day (UTC)")
      ->type_name("YYYY-MM-DD")
      ->check([](const std::string& date) {
        return seconds_of(date) ? std::string() : date + " is no date; write YYYY-MM-DD, as in 2026-11-23";
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
  adder(app, options)("servers", "The server that serves, and those that wait to take over from it",
                      [](Commands& c) { return c.servers(); });
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

}  // namespace headframe
