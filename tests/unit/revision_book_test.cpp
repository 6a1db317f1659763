// What `./run bench servers kills` counts as a contradiction, and what not.
#include "tests/bench/servers/revision_book.hpp"

#include <gtest/gtest.h>

namespace headframe::bench {
namespace {

TEST(RevisionBook, TheSameAgainAndRevisionsThatWereNotReadAreNoContradiction) {
  RevisionBook book;
  for (const std::uint64_t revision : {1, 1, 2, 5, 5}) book.look(revision, "content " + std::to_string(revision));
  EXPECT_EQ(book.seen().revisions, 3U);
  EXPECT_EQ(book.seen().contradictions, 0U);
}

TEST(RevisionBook, OtherContentUnderOneNumberIsOne) {
  RevisionBook book;
  book.look(3, "a at 0");
  book.look(3, "a at 1");
  EXPECT_EQ(book.seen().contradictions, 1U);
  EXPECT_EQ(book.seen().first, "revision 3: a at 0 and a at 1");
}

TEST(RevisionBook, GoingBackIsOneAlsoWithTheSameContent) {
  RevisionBook book;
  book.look(3, "a");
  book.look(4, "b");
  book.look(3, "a");
  EXPECT_EQ(book.seen().contradictions, 1U);
  EXPECT_EQ(book.seen().first, "revision 3 after 4");
}

}  // namespace
}  // namespace headframe::bench
