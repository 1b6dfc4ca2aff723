// Classes of the view's server, on Boost.Beast. Included by server.cc only.
#pragma once

#include <chrono>
#include <deque>
#include <list>
#include <optional>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "platform/view/server/server.h"

namespace godobject::server {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
namespace net = boost::asio;
using net::ip::tcp;
using Error = beast::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds request_patience{5}, write_patience{5}, silence_patience{30};
constexpr std::chrono::milliseconds poll_period{4}, farewell_patience{300};
constexpr std::size_t max_requests = 64, max_streams = 32, max_waiting = 64;
/// Limit of lines on the console: max_lines at once, then one per line_period.
constexpr int max_lines = 40;
constexpr std::chrono::duration<double> line_period{10};
constexpr std::size_t max_line_bytes = 200;
constexpr std::uint32_t max_header_bytes = 8192;
constexpr std::size_t max_message_bytes = 65536;
constexpr int num_default_ports = 10;

struct Message {
  bool binary = false;
  ViewBytes bytes;
};

inline Message text_message(const std::string& text) {
  return {.binary = false, .bytes = std::make_shared<std::vector<std::uint8_t>>(text.begin(), text.end())};
}

class Hub;

/// A WebSocket. Skips frames for a slow client, and closes the connection if the client accepts no bytes for
/// too long.
class Stream : public std::enable_shared_from_this<Stream> {
 public:
  Stream(beast::tcp_stream&& socket, Hub& hub, std::uint64_t id, bool foxglove)
      : socket_(std::move(socket)), hub_(hub), id_(id), foxglove_(foxglove) {}

  void accept(const http::request<http::empty_body>& request);
  /// Sends a frame. Returns false, and sends none, if the client has not accepted the previous ones.
  bool offer(const Message& frame) {
    if (!waiting_.empty()) return false;
    send(frame);
    return true;
  }
  void send(const Message& message);
  void close(websocket::close_code code, std::string_view why);
  /// Closes the connection without a close message.
  void drop() {
    Error ignored;
    ignored = beast::get_lowest_layer(socket_).socket().close(ignored);
  }
  bool is_stalled(Clock::time_point now) const {
    return !waiting_.empty() && now - writing_since_ > write_patience;
  }
  std::uint64_t id() const { return id_; }
  FoxgloveClient* foxglove() { return foxglove_ ? &foxglove_client_ : nullptr; }

 private:
  void read();
  void take(Error error);
  void write();
  void shut();

  websocket::stream<beast::tcp_stream> socket_;
  Hub& hub_;
  std::uint64_t id_;
  bool foxglove_;
  FoxgloveClient foxglove_client_;
  beast::flat_buffer buffer_;
  std::deque<Message> waiting_;  // the first is being written
  Clock::time_point writing_since_;
  std::optional<websocket::close_reason> closing_;
};

/// A connection that requests files, or becomes a stream.
class Requests : public std::enable_shared_from_this<Requests> {
 public:
  Requests(tcp::socket&& socket, Hub& hub) : socket_(std::move(socket)), hub_(hub) {}

  void read();
  void drop() { socket_.close(); }

 private:
  void answer();
  void reply(int status, std::string_view type, std::string_view body);

  beast::tcp_stream socket_;
  Hub& hub_;
  beast::flat_buffer buffer_{max_header_bytes};
  std::optional<http::request_parser<http::empty_body>> parser_;
  http::response<http::span_body<const char>> response_;
  std::string body_;
  ViewBytes frames_;
};

/// All connections, and the timer that feeds the streams. One thread.
class Hub final : public ViewServer {
 public:
  Hub(const ServerSettings& settings, ViewSource& source, Log log)
      : settings_(settings), source_(source), log_(std::move(log)) {}
  ~Hub() override;
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;

  std::string listen();
  void run_thread();
  std::string url() const override {
    const bool v6 = settings_.address.find(':') != std::string::npos;
    const std::string host = v6 ? "[" + settings_.address + "]" : settings_.address;
    return "http://" + host + ":" + std::to_string(port_) + "/?token=" + settings_.token;
  }

  ViewSource& source() { return source_; }
  const Door& door() const { return *door_; }
  /// Prints a line within the limits: the same one at most once a second, and all as max_lines and
  /// line_period allow. The number of suppressed lines is printed with the next one.
  void log(const std::string& line);
  void forget(const Requests* requests) {
    std::erase_if(requests_, [=](const auto& r) { return r.get() == requests; });
  }
  void forget(const Stream* stream);
  void upgrade(beast::tcp_stream&& socket, const http::request<http::empty_body>& request, bool foxglove);
  void joined(Stream& stream);

 private:
  void accept();
  void poll();
  void feed();
  void say_farewell();

  ServerSettings settings_;
  ViewSource& source_;
  Log log_;
  std::optional<Door> door_;
  net::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  net::steady_timer timer_{io_}, accept_timer_{io_};
  bool polling_ = false, ending_ = false;
  std::uint16_t port_ = 0;
  std::uint64_t next_id_ = 1;
  std::list<std::shared_ptr<Requests>> requests_;
  std::list<std::shared_ptr<Stream>> streams_;
  std::string last_line_;
  Clock::time_point last_logged_;
  std::uint64_t num_unsaid_ = 0;
  double allowed_lines_ = max_lines;
  Clock::time_point last_allowed_ = Clock::now();
  std::thread thread_;
};

}  // namespace godobject::server
