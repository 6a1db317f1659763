// Robots that ask what others know around them.

#include "server/net/session_hub.hpp"

namespace headframe {

/// A spare asks nothing.
template <class Question>
void SessionHub::ask(SessionId session, const Question& question, const std::shared_ptr<RobotLink>& link) {
  {
    const std::lock_guard lock(mutex_);
    if (carrier(session).link.lock() != link) return;
  }
  desk_.ask(session, question);
}
template void SessionHub::ask(SessionId, const SurroundingsAsked&, const std::shared_ptr<RobotLink>&);
template void SessionHub::ask(SessionId, const MapAsked&, const std::shared_ptr<RobotLink>&);
template void SessionHub::ask(SessionId, const MapNextAsked&, const std::shared_ptr<RobotLink>&);

void SessionHub::look_around(SessionId session, const RobotLink* link) {
  {
    const std::lock_guard lock(mutex_);
    if (carrier(session).link.lock().get() != link) return;
  }
  desk_.look(session, policy_of(session).bytes_per_s);
}

/// Without a component where it is in none.
SessionSurroundings SessionHub::surroundings_of(SessionId session) const {
  const std::lock_guard lock(mutex_);
  SessionSurroundings around;
  around.revision = atlas_.revision;
  around.receiver = last_part(session);
  for (const Component& component : atlas_.components)
    if (placement_in(component, around.receiver) != nullptr) around.component = {component.id, component.placements};
  for (const Placement& placement : around.component.placements) {
    const auto known = sessions_.find(placement.session);
    if (known == sessions_.end()) continue;
    around.keys[placement.session] = key_for(around.receiver, placement.session);
    around.durable[placement.session] = known->second.keyframes;
    if (known->second.moves > 0) around.moves[placement.session] = known->second.moves;
  }
  return around;
}

}  // namespace headframe
