#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>

namespace headframe {

using Event = std::shared_ptr<const std::string>;

/// What one listener has still to be sent. When more than most_bytes wait, all of it is replaced by a snapshot, so that
/// the queue is bounded and what the listener knows in the end is never wrong. Not thread safe.
class EventQueue {
 public:
  explicit EventQueue(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// snapshot() stands for all that was pushed up to this event.
  void push(const Event& event, const std::function<Event()>& snapshot) {
    events_.push_back(event);
    bytes_ += event->size();
    if (bytes_ <= most_bytes_ || events_.size() == 1) return;
    events_.assign(1, snapshot());
    bytes_ = events_.front()->size();
  }
  /// Null when there is nothing.
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
