#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>

namespace headframe {

using Event = std::shared_ptr<const std::string>;

/// The events that are still to be sent to one client. If several together exceed most_bytes, a snapshot replaces all
/// of them; so the queue never holds more than most_bytes or one event, and the client still ends up with the right
/// state. Not thread safe.
class EventQueue {
 public:
  explicit EventQueue(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// snapshot() returns an event that replaces all events up to and including this one.
  void push(const Event& event, const std::function<Event()>& snapshot) {
    events_.push_back(event);
    bytes_ += event->size();
    if (bytes_ <= most_bytes_ || events_.size() == 1) return;
    events_.assign(1, snapshot());
    bytes_ = events_.front()->size();
  }
  /// Null if the queue is empty.
  Event pop() {
    if (events_.empty()) return nullptr;
    Event event = std::move(events_.front());
    events_.pop_front();
    bytes_ -= event->size();
    return event;
  }
  std::size_t bytes() const { return bytes_; }

 private:
  const std::size_t most_bytes_;
  std::deque<Event> events_;
  std::size_t bytes_ = 0;
};

}  // namespace headframe
