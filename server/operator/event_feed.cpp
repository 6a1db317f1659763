#include "server/operator/event_feed.hpp"

#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

#include "server/operator/event_queue.hpp"
#include "server/operator/log_lines.hpp"

namespace headframe {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using Code = beast::error_code;

/// One client. Everything except tell() and close() runs on the strand of its socket.
class EventSocket : public std::enable_shared_from_this<EventSocket> {
 public:
  EventSocket(WebStream stream, std::shared_ptr<EventFeed> feed, std::size_t queued_bytes, OperatorIdentity listener)
      : who(std::move(listener)), socket_(std::move(stream)), feed_(std::move(feed)), queue_(queued_bytes) {}
  ~EventSocket() { feed_->give_place(); }
  EventSocket(const EventSocket&) = delete;
  EventSocket& operator=(const EventSocket&) = delete;

  void accept(EventFeed::Request request) {
    socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_.read_message_max(1024);                                    // clients need not send anything
    if (!request[beast::http::field::sec_websocket_protocol].empty())  // a page sends its token in this field
      socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
        response.set(beast::http::field::sec_websocket_protocol, "headframe");
      }));
    auto kept = std::make_shared<EventFeed::Request>(std::move(request));
    socket_.async_accept(*kept, [self = shared_from_this(), kept](Code code) {
      if (code) return;
      self->feed_->join(self);
      self->read();
    });
  }

  void tell(const Event& event, const std::function<Event()>& snapshot) {
    net::post(socket_.get_executor(), [self = shared_from_this(), event, snapshot] {
      self->queue_.push(event, snapshot);
      if (!self->writing_) self->write();
    });
  }

  const OperatorIdentity who;

  void close() {
    net::post(socket_.get_executor(), [self = shared_from_this()] { self->end(); });
  }

 private:
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](Code code, std::size_t) {
      if (code) return self->end();
      self->buffer_.clear();
      self->read();
    });
  }

  void write() {
    const Event event = ended_ ? nullptr : queue_.pop();
    if (!event) return;
    writing_ = true;
    socket_.text(true);
    socket_.async_write(net::buffer(*event), [self = shared_from_this(), event](Code code, std::size_t) {
      self->writing_ = false;
      code ? self->end() : self->write();
    });
  }

  void end() {
    if (std::exchange(ended_, true)) return;
    beast::get_lowest_layer(socket_).close();
    feed_->leave(shared_from_this());
  }

  websocket::stream<WebStream> socket_;
  const std::shared_ptr<EventFeed> feed_;
  beast::flat_buffer buffer_;
  EventQueue queue_;
  bool writing_ = false, ended_ = false;
};

bool EventFeed::take_place() {
  if (++places_ <= limits_.clients && !stopped_) return true;
  --places_;
  return false;
}

void EventFeed::give_place() { --places_; }

void EventFeed::serve(WebStream stream, Request request, const OperatorIdentity& who) {
  stream.next_layer().expires_never();
  std::make_shared<EventSocket>(std::move(stream), shared_from_this(), limits_.queued_bytes, who)
      ->accept(std::move(request));
}

/// Call with the lock held.
void EventFeed::end_expired() {
  if (people_ == nullptr) return;
  const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
  for (const auto& socket : sockets_)
    if (!people_->stands(socket->who, now.count())) socket->close();
}

void EventFeed::end(const std::string& name) {
  const std::lock_guard lock(mutex_);
  for (const auto& socket : sockets_)
    if (socket->who.name == name) socket->close();
}

void EventFeed::stop() {
  std::set<std::shared_ptr<EventSocket>> sockets;
  {
    const std::lock_guard lock(mutex_);
    if (!stopped_.exchange(true) && last_) news(std::make_shared<const StationLook>(look_at(station_)));  // for the log
    sockets.swap(sockets_);
    timer_.cancel();
  }
  for (const auto& socket : sockets) socket->close();
}

void EventFeed::start() {
  const std::lock_guard lock(mutex_);
  if (stopped_ || last_) return;
  last_ = std::make_shared<const StationLook>(look_at(station_));
  log_->add({"started", "The server started."});
  look_again();
}

void EventFeed::join(const std::shared_ptr<EventSocket>& socket) {
  const std::lock_guard lock(mutex_);
  if (stopped_) return socket->close();
  if (sockets_.empty()) {  // without clients, polls were rare
    news(std::make_shared<const StationLook>(look_at(station_)));
    sockets_.insert(socket);
    look_again();
  }
  sockets_.insert(socket);
  auto snapshot = std::make_shared<const std::string>(snapshot_event(*last_));
  socket->tell(snapshot, [snapshot] { return snapshot; });
}

void EventFeed::leave(const std::shared_ptr<EventSocket>& socket) {
  const std::lock_guard lock(mutex_);
  sockets_.erase(socket);
}

/// Call with the lock held. Cancels a wait in progress.
void EventFeed::look_again() {
  timer_.expires_after(sockets_.empty() ? limits_.look_alone : limits_.look);
  timer_.async_wait([weak = weak_from_this()](Code code) {
    if (const auto self = weak.lock(); self && !code) self->look();
  });
}

/// The events that lead clients to the state `now`, which becomes last_; also writes log entries. Call with the lock
/// held.
std::vector<std::string> EventFeed::news(const std::shared_ptr<const StationLook>& now) {
  std::vector<std::string> events;
  if (last_) {
    events = events_between(*last_, *now);
    for (LogEntry& line : log_lines(*last_, *now)) log_->add(std::move(line));
  }
  for (const LogEntry& entry : log_->since(told_)) {
    events.push_back(log_event(entry));
    told_ = entry.id;
  }
  last_ = now;
  return events;
}

void EventFeed::look() {
  const std::lock_guard lock(mutex_);
  if (stopped_) return;
  end_expired();
  const auto now = std::make_shared<const StationLook>(look_at(station_));
  const auto snapshot = [now] { return std::make_shared<const std::string>(snapshot_event(*now)); };
  for (std::string& text : news(now)) {
    const auto event = std::make_shared<const std::string>(std::move(text));
    for (const auto& socket : sockets_) socket->tell(event, snapshot);
  }
  look_again();
}

}  // namespace headframe
