// Robots that ask where they are.

#include "common/wire/convert.hpp"
#include "server/net/session_hub.hpp"

namespace headframe {

/// A question that stands already is not asked again: one of a session at a time. What came before it is durable when
/// the worker hears of it.
void SessionHub::handle(SessionId session, const WhereAsked& event, const std::shared_ptr<RobotLink>& link) {
  {
    const std::lock_guard lock(mutex_);
    Session& known = carrier(session);
    if (known.link.lock() != link || known.asks_where == event.asks) return;  // a spare's, or said before
    known.asks_where = event.asks;
  }
  write(PutMerge{}, link, 0, [this, session] {
    const std::lock_guard lock(mutex_);
    news_.asks_where(last_part(session), carrier(session).asks_where);
  });
}

void SessionHub::tell_localization(SessionId session, const SessionLocalization& l) {
  v1::ServerMessage message;
  auto& told = *message.mutable_localization();
  told.set_found(l.found);
  told.set_merged(l.merged);
  told.set_probability(l.probability);
  told.set_shared_m(l.shared_m);
  told.set_awaited_m(l.awaited_m);
  told.set_look_alikes(l.look_alikes);
  told.set_missing(l.missing);
  std::shared_ptr<RobotLink> robot;
  {
    const std::lock_guard lock(mutex_);
    const Session& asking = sessions_.at(session);
    told.set_keyframe(l.keyframe + (l.keyframe == 0 ? 0 : asking.from - 1));
    if (asking.asks_where) robot = asking.link.lock();
    if (l.found) {
      told.set_component(static_cast<std::uint64_t>(l.component));
      *told.mutable_anchor() = to_proto(key_for(session, l.component));
      *told.mutable_session() = to_proto(key_for(session, l.on));
    }
  }
  if (l.found) {
    *told.mutable_t_component_session() = to_proto(l.T_component_session);
    *told.mutable_t_component_sensor() = to_proto(l.T_component_sensor);
    for (Eigen::Index i = 0; i < 36; ++i) told.add_covariance(l.covariance(i / 6, i % 6));
  }
  if (robot) robot->tell_localization(std::make_shared<const std::string>(message.SerializeAsString()));
}

}  // namespace headframe
