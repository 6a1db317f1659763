#include <chrono>

#include "server/operator/json_text.hpp"
#include "server/operator/request_target.hpp"
#include "server/operator/routes.hpp"

namespace headframe::routes {
namespace {

constexpr double default_days = 30;

Result<OperatorRegistry*> registry(const Context& context) {
  if (context.records.people != nullptr) return context.records.people;
  return failure(ErrorCode::refused, "this server runs with --insecure: whoever reaches it may do anything");
}

Json identity_object(const OperatorIdentity& who) {
  return {{"name", who.name.empty() ? Json() : Json(who.name)},
          {"role", std::string(to_string(who.role))},
          {"expires_s", who.expires_s > 0 ? Json(who.expires_s) : Json()}};
}

}  // namespace

/// The operator who asks, and all routes that this operator may use.
Result<Reply> me(const Query&, const Context& context) {
  Json out = identity_object(context.who);
  out["may"] = Json::array();
  for (const RouteName& route : route_names())
    if (context.who.role >= role_for(route.method, route.path))
      out["may"].push_back(std::string(route.method) + " " + std::string(route.path));
  return json(text(out));
}

/// The connection creates the cookie, because it knows which credentials were shown.
Result<Reply> sign_in(const Query&, const Context& context) {
  Ready out = json(text(identity_object(context.who)));
  out.page = Ready::Page::begins;
  return out;
}

Result<Reply> sign_out(const Query&, const Context&) {
  Ready out = json(text({{"signed_out", true}}));
  out.page = Ready::Page::ends;
  return out;
}

Result<Reply> operators(const Query&, const Context& context) {
  const auto people = registry(context);
  if (!people) return tl::unexpected(people.error());
  Json rows = Json::array();
  for (const OperatorIdentity& who : (*people)->operators()) rows.push_back(identity_object(who));
  return json(text({{"operators", std::move(rows)}}));
}

Result<Reply> add_operator(const Query& query, const Context& context) {
  const auto people = registry(context);
  const auto name = required(query, "name");
  if (!people || !name) return tl::unexpected(people ? name.error() : people.error());
  const auto wanted = query.find("role"), given = query.find("days");
  const auto role = wanted == query.end() ? Role::operate : role_from(wanted->second);
  if (!role)
    return failure(ErrorCode::invalid_argument,
                   "\"" + wanted->second + "\" is no role; there are view, operate and administer");
  const auto days = given == query.end() ? default_days : parse_number("days", given->second, 0.001, 3650);
  if (!days) return tl::unexpected(days.error());
  return Later{[people = *people, name = *name, role = *role, days = *days,
                ended = context.records.on_revoked](const std::function<void(Ready)>& answer) {
                 const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
                 const auto token = people->add(name, role, days * 86400, now.count());
                 if (!token) return answer(error_reply(token.error()));
                 if (ended) ended(name);  // event streams opened with an earlier token of this name
                 Json out = identity_object({name, role, now.count() + days * 86400});
                 out["token"] = *token;
                 answer(json(text(out), 201));
               },
               true};
}

Result<Reply> revoke_operator(const Query& query, const Context& context) {
  const auto people = registry(context);
  const auto name = required(query, "name");
  if (!people || !name) return tl::unexpected(people ? name.error() : people.error());
  return Later{
      [people = *people, name = *name, ended = context.records.on_revoked](const std::function<void(Ready)>& answer) {
        const auto done = people->revoke(name);
        if (done && ended) ended(name);
        answer(done ? json("{\"revoked\":true}\n") : error_reply(done.error()));
      },
      true};
}

}  // namespace headframe::routes
