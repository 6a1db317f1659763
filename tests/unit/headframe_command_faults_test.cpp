// What the command completes, and what it says of wrong use and faults.
#include <csignal>

#include "tests/support/headframe_command_fixture.hpp"

namespace headframe {
namespace {

/// What a shell is given on its standard input, and prints; none where the machine lacks the shell.
std::optional<std::string> said_by(const std::string& shell, const std::string& script, const fs::path& folder) {
  if (std::system(("command -v " + shell + " >" + (folder / "out").string()).c_str()) != 0) return std::nullopt;
  std::ofstream(folder / "script") << script;
  std::ignore = std::system(
      ("timeout 20 " + shell + " " + (folder / "script").string() + " >" + (folder / "out").string() + " 2>&1")
          .c_str());
  return contents(folder / "out");
}

TEST_F(HeadframeCommand, CompletesInBash) {
  const auto completed = [&](const std::string& words, int at) {
    return *said_by("bash",
                    std::string("source <(") + HEADFRAME_COMMAND + " completion)\nCOMP_WORDS=(" + words +
                        ")\nCOMP_CWORD=" + std::to_string(at) + "\n_headframe\necho \"${COMPREPLY[@]}\"\n",
                    folder);
  };
  EXPECT_EQ(completed("headframe ref", 1), "refuse\n");
  EXPECT_EQ(completed("headframe re", 1), "refuse retract rename request-clouds\n");
  EXPECT_EQ(completed("headframe survey s", 2), "set\n");
  EXPECT_EQ(completed("headframe survey set --j", 3), "--json\n");
  EXPECT_EQ(completed("headframe robot add l", 3), "\n") << "list is a word after robot, not after robot add";
  EXPECT_EQ(completed("headframe export --fra", 2), "--frame\n");
  EXPECT_EQ(completed("headframe export --v", 2), "--voxel\n");
}

TEST_F(HeadframeCommand, CompletesInZsh) {
  // A terminal of its own, in which the line is typed: the widgets of zsh work nowhere else.
  const auto typed = [&](const std::string& line, const std::string& becomes) {
    return said_by(
        "zsh",
        "zmodload zsh/zpty\nzpty z zsh -f\nzpty -w z \"PS1=; autoload -Uz compinit; compinit -u -D; source <(" +
            std::string(HEADFRAME_COMMAND) + " completion zsh); print rea''dy\"\n" +
            "zpty -r z seen '*ready'$'\\r''*'\nzpty -w -n z '" + line + "'$'\\t'\nzpty -r z seen '*" + becomes +
            "*' && echo completed\n",
        folder);
  };
  if (!typed("headframe ref", "headframe refuse")) GTEST_SKIP() << "no zsh here";
  EXPECT_EQ(typed("headframe ref", "headframe refuse"), "completed\n");
  EXPECT_EQ(typed("headframe survey s", "headframe survey set"), "completed\n");
  EXPECT_EQ(typed("headframe export --v", "headframe export --voxel"), "completed\n");
  EXPECT_EQ(typed("headframe sta", "headframe status"), "completed\n");
}

TEST_F(HeadframeCommand, CompletesInFish) {
  const auto completed = [&](const std::string& line) {
    return said_by("fish", std::string(HEADFRAME_COMMAND) + " completion fish | source\ncomplete -C '" + line + "'\n",
                   folder);
  };
  const auto said = completed("headframe ref");
  if (!said) GTEST_SKIP() << "no fish here";
  EXPECT_EQ(*said, "refuse\tDo not propose this placement again on much the same evidence\n");
  EXPECT_EQ(*completed("headframe survey s"), "set\tSet a session's survey\n");
  EXPECT_EQ(*completed("headframe survey set --j"), "--json\tPrint JSON\n");
  EXPECT_EQ(*completed("headframe export --vox"),
            "--voxel\tOne point per cube within each keyframe, 0: every point (default 0.1)\n");
}

TEST_F(HeadframeCommand, WrongUseIsStatus2) {
  expect_fault(run(""), 2, "say what to do");
  expect_fault(run("atlsa"), 2, "atlsa");
  expect_fault(run("completion csh"), 2, "csh");
  expect_fault(run("atlas --wait soon"), 2, "soon");
  expect_fault(run("atlas --wait -1"), 2, "-1");
  expect_fault(run("export --component 1 " + path("map.stl")), 2, ".ply, .pcd, .las, .pdf, .svg and .png");
  expect_fault(run("export " + path("map.ply")), 2, "--component");
  expect_fault(run("export --component 1 --scale 200 " + path("map.ply")), 2, "--scale is of a plan");
  expect_fault(run("export --component 1 --voxel 0.1 " + path("map.pdf")), 2, "--voxel is of points");
  expect_fault(run_at("nowhere", "status"), 2, "HOST:PORT");
  expect_fault(run_at("127.0.0.1:0", "status"), 2, "HOST:PORT");
  expect_fault(run_at("127.0.0.1:65536", "status"), 2, "HOST:PORT");
  expect_fault(run("robot"), 2, "headframe robot has list, add, rate, revoke");
  expect_fault(run("robot rate r1 -5"), 2, "-5 not in range");
  EXPECT_EQ(run("--version").out.rfind("headframe ", 0), 0U);
  EXPECT_EQ(run("--help").code, 0);
}

TEST_F(HeadframeCommand, FaultsAreOneLineAndLeaveNothingBehind) {
  expect_fault(run("export --component 2 " + path("map.ply")), 1, "no component 2; there are 1, 3");
  expect_fault(run("export --component 1 " + path("no/map.ply")), 1, "No such file or directory");
  fs::create_directory(path("folder.ply"));
  expect_fault(run("export --component 1 " + path("folder.ply")), 1, "it is a directory");
  fs::remove(path("folder.ply"));
  expect_fault(run("trajectory delta " + path("t.txt")), 1, "there are alpha/run/1, beta/run/1, gamma \"3\"/run/1");
  server.station.rows[1].key = {"alpha", "run/2"};
  expect_fault(run("trajectory alpha " + path("t.txt")), 1, "several sessions");
  expect_fault(run_at("127.0.0.1:1", "status"), 1, "no headframe-server answers at 127.0.0.1:1");
  EXPECT_EQ(files(), std::set<std::string>{});
}

TEST_F(HeadframeCommand, AnExportThatBreaksOffKeepsTheOldFile) {
  std::ofstream(path("map.ply")) << "old";
  server.station.cloud_that_breaks = 5;  // after the first points went out
  expect_fault(run("export --component 3 " + path("map.ply")), 1, "broke off");
  EXPECT_EQ(contents(path("map.ply")), "old");
  EXPECT_EQ(files(), std::set<std::string>{"map.ply"});
}

TEST_F(HeadframeCommand, ShowsTheTokenOfAFileThatIsItsOwners) {
  const OperatorServer locked({}, {"right", nullptr});
  std::ofstream(path("token")) << "right\n";
  fs::permissions(path("token"), fs::perms::owner_read);
  EXPECT_EQ(run_at(locked.where(), "--token-file " + path("token") + " status").code, 0);
  expect_fault(run_at(locked.where(), "status"), 1, "operator.token");
  fs::permissions(path("token"), fs::perms::owner_read | fs::perms::others_read);
  expect_fault(run_at(locked.where(), "--token-file " + path("token") + " status"), 1, "chmod 600");
  expect_fault(run_at(locked.where(), "--token-file " + path("none") + " status"), 1, "none");
}

TEST_F(HeadframeCommand, AFullDiskIsSaid) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  fs::create_symlink("/dev/full", path("map.ply.part"));
  expect_fault(run("export --component 1 " + path("map.ply")), 1, "No space left on device");
  EXPECT_EQ(files(), std::set<std::string>{});
}

TEST_F(HeadframeCommand, AnInterruptedExportLeavesNothing) {
  server.station.cloud_gate.lock();  // the export stops at its first cloud
  std::jthread interrupt([&] {
    while (server.station.clouds_read == 0) std::this_thread::yield();
    EXPECT_TRUE(fs::exists(path("map.ply.part")));
    std::ignore = std::system(("kill -INT $(cat " + path("pid") + ")").c_str());
  });
  const std::string line = "echo $$ >" + path("pid") + "; exec " + HEADFRAME_COMMAND + " --http " + server.where() +
                           " export --component 1 " + path("map.ply");
  const int status = std::system(("sh -c '" + line + "'").c_str());
  interrupt.join();
  server.station.cloud_gate.unlock();
  EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 128 + SIGINT) << status;
  EXPECT_EQ(files(), std::set<std::string>{"pid"});
}

}  // namespace
}  // namespace headframe
