// Notes on the map: kept over restarts, bounded, and with a word for everything that is no note.
#include "server/operator/note_book.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "server/operator/note_json.hpp"
#include "tests/support/operator_api_fixture.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

Note note_with(const std::string& text, std::size_t places = 1, const std::string& kind = "note") {
  Note note{kind, text, {}, "anna"};
  for (std::size_t i = 0; i < places; ++i) note.places.push_back({7, {static_cast<double>(i), 0.5, -2}});
  return note;
}

std::vector<std::string> texts_in(const NoteBook& book) {
  std::vector<std::string> out;
  for (const Note& note : book.notes()) out.push_back(std::to_string(note.id) + " " + note.text);
  return out;
}

using Lines = std::vector<std::string>;

TEST(NoteBook, IsThereAfterARestartAndGivesNoIdTwice) {
  const TempDir folder;
  const auto file = folder.path() / "notes.jsonl";
  {
    NoteBook book(file);
    for (const std::string text : {"a", "b", "c"}) ASSERT_TRUE(book.add(note_with(text)));
    EXPECT_EQ(book.remove(3)->text, "c");
    EXPECT_EQ(book.remove(3).error().code, ErrorCode::not_found);
  }
  {
    NoteBook book(file);
    EXPECT_EQ(texts_in(book), (Lines{"1 a", "2 b"}));
    EXPECT_EQ(book.add(note_with("d"))->id, 4U);
  }
  const Note kept = NoteBook(file).notes().back();
  EXPECT_EQ(std::pair(kept.by, kept.places[0].session), std::pair(std::string("anna"), SessionId{7}));
  EXPECT_EQ(kept.places[0].p_session, (std::array<double, 3>{0, 0.5, -2}));
}

TEST(NoteBook, ALineThatIsDamagedOrCutOffCostsItselfAlone) {
  const TempDir folder;
  const auto file = folder.path() / "notes.jsonl";
  (void)NoteBook(file).add(note_with("before"));
  std::ofstream(file, std::ios::app) << "no "
                                        "json\n[]\n{\"removed\":-1}\n{\"removed\":1e300}\n{\"id\":18446744073709551615,"
                                        "\"kind\":\"note\",\"text\":\"x\","
                                        "\"at_s\":1,\"places\":[]}\n{\"id\": 9, \"kind\": \"no";
  NoteBook book(file);
  EXPECT_EQ(book.add(note_with("after"))->id, 2U);
  EXPECT_EQ(texts_in(NoteBook(file)), (Lines{"1 before", "2 after"}));
}

TEST(NoteBook, HasItsLimitsOnBothSides) {
  NoteBook book({}, {.notes = 2, .text_bytes = 3, .places = 4});
  const auto code_of = [&](const Note& note) {
    const auto added = book.add(note);
    return added ? std::optional<ErrorCode>() : added.error().code;
  };
  for (const Note& wrong : {note_with("1234"), note_with(""), note_with("abc", 0), note_with("abc", 5),
                            note_with("", 1, "distance"), note_with("", 2, "area"), note_with("abc", 1, "novel")})
    EXPECT_EQ(code_of(wrong), ErrorCode::invalid_argument) << wrong.kind << " " << wrong.text;
  Note nowhere = note_with("abc");
  nowhere.places[0].p_session[1] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(code_of(nowhere), ErrorCode::invalid_argument);
  EXPECT_EQ(code_of(note_with("abc", 4)), std::nullopt);
  EXPECT_EQ(code_of(note_with("", 3, "area")), std::nullopt);
  EXPECT_EQ(code_of(note_with("abc")), ErrorCode::refused);
  ASSERT_TRUE(book.remove(1));
  EXPECT_EQ(code_of(note_with("abc")), std::nullopt);
}

TEST(NoteBook, ItsFileStaysSmallHoweverOftenNotesComeAndGo) {
  const TempDir folder;
  const auto file = folder.path() / "notes.jsonl";
  NoteBook book(file, {.notes = 3});
  ASSERT_TRUE(book.add(note_with("stays")));
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(book.remove(book.add(note_with("goes"))->id));
  EXPECT_LT(std::filesystem::file_size(file), 3000U);
  EXPECT_EQ(texts_in(NoteBook(file)), Lines{"1 stays"});
}

TEST(NoteBook, WhatCanNotBeWrittenIsRefusedAndNotThere) {
  NoteBook book("/nowhere/notes.jsonl");
  EXPECT_EQ(book.add(note_with("a")).error().code, ErrorCode::unavailable);
  EXPECT_TRUE(book.notes().empty());
}

TEST_F(OperatorApiTest, NotesAreWrittenSeenTakenAwayAndLogged) {
  const std::string body = R"({"kind":"distance","text":"wide","places":[{"session_id":1,"p_session":[1,2,3]},)"
                           R"({"session_id":2,"p_session":[4,5,6]}]})";
  EXPECT_EQ(taken(client.post("/api/v1/notes", body)).status, 201);
  const Json all = Json::parse(get("/api/v1/notes").body)["notes"];
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0]["text"], "wide");
  EXPECT_EQ(all[0]["places"][1]["p_session"], (Json{4.0, 5.0, 6.0}));
  expect_error(taken(client.post("/api/v1/notes", "{}")), 400, "bad_input", "no places");
  expect_error(taken(client.post("/api/v1/notes", R"({"kind":"note","text":"a","places":[{"session_id":1}]})")), 400,
               "bad_input", "place 1");
  expect_error(taken(client.remove("/api/v1/notes/9")), 404, "not_found", "no note 9");
  EXPECT_EQ(taken(client.remove("/api/v1/notes/1")).status, 200);
  const Json log = Json::parse(get("/api/v1/log").body)["entries"];
  std::vector<std::string> lines;
  for (const Json& entry : log)
    if (entry["kind"] == "note") lines.push_back(entry["text"]);
  EXPECT_EQ(lines, (std::vector<std::string>{"An operator wrote a distance: \"wide\".",
                                             "An operator took away a distance: \"wide\"."}));
}

}  // namespace
}  // namespace headframe
