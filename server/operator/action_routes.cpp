#include "server/operator/routes.hpp"

#include "server/operator/api_json.hpp"

namespace headframe::routes {

/// POST /api/v1/alignments/{id}/{decision}
Result<Reply> decide(const Query& query, const Context& context) {
  const auto id = alignment_named(query);
  if (!id) return tl::unexpected(id.error());
  const std::string& name = query.at("decision");
  const auto decision = decision_from(name);
  if (!decision || *decision == Decision::place)
    return failure(ErrorCode::not_found,
                   "\"" + name + "\" is no decision; there are confirm, refuse, retract and undo");
  return Later{[&station = context.station, id = *id, decision = *decision](auto answer) {
    station.decide(id, decision, [&station, id, answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json(alignment_json(station.atlas(), id)) : error_reply(done.error()));
    });
  }};
}

Result<Reply> merge(const Query&, const Context& context) {
  context.station.merge_all();
  return json("{\"queued\":true}\n", 202);
}

Result<Reply> rename(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  const auto name = query.find("name");
  if (name == query.end())
    return failure(ErrorCode::invalid_argument, "parameter \"name\" is missing; leave it empty to take the label away");
  return Later{[&station = context.station, row = *row, label = name->second](auto answer) mutable {
    row.label = label;
    station.rename(row.id, label, [&station, row, answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json(session_json(row, station.atlas().atlas)) : error_reply(done.error()));
    });
  }};
}

Result<Reply> anchor(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  return Later{[&station = context.station, id = row->id](auto answer) {
    station.anchor(id, [&station, id, answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json(anchor_json(station.atlas().atlas, id)) : error_reply(done.error()));
    });
  }};
}

Result<Reply> request_clouds(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  return Later{[&station = context.station, id = row->id](auto answer) {
    station.request_clouds(id, [answer = std::move(answer)](const Result<std::size_t>& asked) {
      if (asked) return answer(json("{\"requested\":" + std::to_string(*asked) + "}\n", 202));
      answer(asked.error().code == ErrorCode::refused ? error_reply(409, asked.error()) : error_reply(asked.error()));
    });
  }};
}

Result<Reply> quarantine(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  constexpr std::size_t most_bytes = 256;
  const auto given = query.find("reason");
  std::string why = given == query.end() ? "" : given->second.substr(0, most_bytes);
  if (why.empty()) why = "by the operator";
  return Later{[&station = context.station, row = *row, why](auto answer) mutable {
    row.why_aside = why;
    station.set_aside(row.id, why, [&station, row, answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json(session_json(row, station.atlas().atlas)) : error_reply(done.error()));
    });
  }};
}

Result<Reply> release(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  return Later{[&station = context.station, row = *row](auto answer) mutable {
    row.why_aside.clear();
    station.release(row.id, [&station, row, answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json(session_json(row, station.atlas().atlas)) : error_reply(done.error()));
    });
  }};
}

Result<Reply> remove_session(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  return Later{[&station = context.station, id = row->id](auto answer) {
    station.remove(id, [answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json("{\"deleted\":true}\n") : error_reply(done.error()));
    });
  }};
}

}  // namespace headframe::routes
