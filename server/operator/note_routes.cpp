#include "server/operator/note_json.hpp"
#include "server/operator/routes.hpp"

namespace headframe::routes {
namespace {

Result<std::shared_ptr<NoteBook>> book(const Context& context) {
  if (context.records.notes) return context.records.notes;
  return failure(ErrorCode::unavailable, "this server keeps no notes");
}

LogEntry line(const OperatorIdentity& who, const std::string& did, const Note& note) {
  const std::string what = note.kind == "note" ? "a note" : note.kind == "area" ? "an area" : "a " + note.kind;
  const std::string quoted = note.text.empty() ? "" : ": \"" + note.text + "\"";
  const SessionId about = note.places.empty() ? 0 : note.places.front().session;
  return {"note", (who.name.empty() ? "An operator" : who.name) + did + what + quoted + ".", about, 0, who.name};
}

}  // namespace

Result<Reply> notes(const Query&, const Context& context) {
  const auto there = book(context);
  if (!there) return tl::unexpected(there.error());
  return json(notes_json((*there)->notes()));
}

Result<Reply> add_note(const Query&, const Context& context) {
  const auto there = book(context);
  auto note = note_from_json(context.body);
  if (!there || !note) return tl::unexpected(there ? note.error() : there.error());
  note->by = context.who.name;
  return Later{[book = *there, log = context.records.log, who = context.who,
                note = std::move(*note)](const std::function<void(Ready)>& answer) {
                 const auto added = book->add(note);
                 if (added && log) log->add(line(who, " wrote ", *added));
                 answer(added ? json(note_json(*added), 201) : error_reply(added.error()));
               },
               true};
}

Result<Reply> remove_note(const Query& query, const Context& context) {
  const auto there = book(context);
  const auto id = whole(query.at("id"));
  if (!there) return tl::unexpected(there.error());
  if (!id || *id < 1) return failure(ErrorCode::not_found, "there is no note \"" + query.at("id") + "\"");
  return Later{[book = *there, log = context.records.log, who = context.who,
                id = static_cast<std::uint64_t>(*id)](const std::function<void(Ready)>& answer) {
                 const auto removed = book->remove(id);
                 if (removed && log) log->add(line(who, " took away ", *removed));
                 answer(removed ? json(note_json(*removed)) : error_reply(removed.error()));
               },
               true};
}

}  // namespace headframe::routes
