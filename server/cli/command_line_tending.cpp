// Commands that tend sessions and say who may come in.
#include "server/cli/command_line.hpp"

namespace headframe {

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

void add_site_commands(CLI::App& app, Options& options) {
  CLI::App* sites = app.add_subcommand("site", "Mines that share this server: sessions of two are never merged");
  sites->add_flag("--json", options.json, "Print JSON");
  const auto add = adder(*sites, options);
  add("list", "All sites, and what belongs to each", [](Commands& c) { return c.list_sites(); });
  const auto named = [&](CLI::App* sub) {
    sub->add_option("SITE", options.site, "A name for the mine; without it: none");
  };
  CLI::App* of_robot = add("robot", "Where a robot drives, from its next session on",
                           [&](Commands& c) { return c.set_robot_site(options.robot, options.site); });
  of_robot->add_option("NAME", options.robot, "Of the robot")->required();
  named(of_robot);
  CLI::App* of_session = add("session", "Where a session was driven: what merged it with others elsewhere is undone",
                             [&](Commands& c) { return c.set_session_site(options.session, options.site); });
  of_session->add_option("SESSION", options.session, session_help)->required();
  named(of_session);
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

}  // namespace headframe
