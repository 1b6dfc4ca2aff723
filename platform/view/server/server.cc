// HTTP and WebSocket server on Boost, which is included by parts.h alone.
#include "platform/view/server/server.h"

#include <algorithm>
#include <chrono>

#include "platform/rt/signals.h"
#include "platform/view/server/parts.h"

namespace godobject {
namespace server {

// --- a stream ---------------------------------------------------------------------------------------

void Stream::accept(const http::request<http::empty_body>& request) {
  beast::get_lowest_layer(socket_).expires_never();
  socket_.set_option(websocket::stream_base::timeout{
      .handshake_timeout = request_patience, .idle_timeout = silence_patience, .keep_alive_pings = true});
  socket_.set_option(
      websocket::stream_base::decorator([foxglove = foxglove_](websocket::response_type& response) {
        response.set(http::field::sec_websocket_protocol, foxglove ? foxglove_protocol : stream_protocol);
      }));
  socket_.read_message_max(max_message_bytes);
  socket_.auto_fragment(false);
  socket_.async_accept(request, [self = shared_from_this()](Error error) {
    if (error) return self->hub_.forget(self.get());
    self->hub_.joined(*self);
    self->read();
  });
}

void Stream::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](Error error, std::size_t) { self->take(error); });
}

void Stream::take(Error error) {
  if (error) {
    if (error == websocket::error::message_too_big || error == websocket::error::buffer_overflow)
      hub_.log("a client was closed: a message of more than " + std::to_string(max_message_bytes) + " bytes");
    return hub_.forget(this);
  }
  const auto data = buffer_.cdata();
  const std::span bytes(static_cast<const std::uint8_t*>(data.data()), data.size());
  if (foxglove_) {
    const std::string reply = foxglove_client_.take(socket_.got_text(), bytes);
    if (!reply.empty()) send(text_message(reply));
  } else {
    PointerMessage message;
    JointsMessage joints;
    PaceMessage pace;
    ResetMessage reset;
    const auto is = [&](auto& of) { return socket_.got_binary() && decode(bytes, of) == ParseResult::ok; };
    ViewSource& source = hub_.source();
    if (is(reset)) {
      if (const std::string why_not = source.reset(); !why_not.empty())
        hub_.log("a reset was ignored: " + why_not);
    } else if (is(pace)) {
      if (!source.set_pace(id_, pace))
        hub_.log("a pause was ignored: it needs --view-input or --fast, and a run without hardware");
    } else if (const bool of_joints = is(joints); of_joints || is(message)) {
      if (!(of_joints ? source.move_joints(id_, joints) : source.point(id_, message)))
        hub_.log(
            "a pointer message was ignored: --view-input is not given, or another client moves the tool");
    } else {
      hub_.log("a client was closed: it sent no valid pointer message");
      return close(websocket::close_code::policy_error, "this is no valid pointer message");
    }
  }
  buffer_.consume(buffer_.size());
  read();
}

void Stream::send(const Message& message) {
  if (closing_ || !socket_.is_open()) return;
  if (waiting_.size() >= max_waiting) return drop();
  waiting_.push_back(message);
  if (waiting_.size() == 1) write();
}

void Stream::write() {
  writing_since_ = Clock::now();
  socket_.binary(waiting_.front().binary);
  const std::vector<std::uint8_t>& bytes = *waiting_.front().bytes;
  socket_.async_write(net::buffer(bytes.data(), bytes.size()),
                      [self = shared_from_this()](Error error, std::size_t) {
                        self->waiting_.pop_front();
                        if (error) return;  // and the read ends with an error, too
                        if (self->closing_) return self->shut();
                        if (!self->waiting_.empty()) self->write();
                      });
}

void Stream::close(websocket::close_code code, std::string_view why) {
  if (closing_) return;
  closing_.emplace(code, why);
  if (waiting_.empty()) shut();
}

void Stream::shut() {
  socket_.async_close(*closing_, [self = shared_from_this()](Error) { self->hub_.forget(self.get()); });
}

// --- requests ---------------------------------------------------------------------------------------

void Requests::read() {
  parser_.emplace();
  parser_->header_limit(max_header_bytes);
  parser_->body_limit(0);
  socket_.expires_after(request_patience);
  http::async_read(socket_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
    if (!error) return self->answer();
    if (error != http::error::end_of_stream && error != net::error::operation_aborted)
      self->hub_.log("a request was refused: " + error.message());
    self->hub_.forget(self.get());
  });
}

void Requests::answer() {
  const http::request<http::empty_body>& request = parser_->get();
  const auto text = [](beast::string_view view) { return std::string_view(view.data(), view.size()); };
  KnockHead head{.method = text(request.method_string()),
                 .target = text(request.target()),
                 .host = text(request[http::field::host]),
                 .upgrade = websocket::is_upgrade(request),
                 .protocols = text(request[http::field::sec_websocket_protocol])};
  if (request.count(http::field::origin) > 0) head.origin = text(request[http::field::origin]);
  const Verdict verdict = hub_.door().judge(head);
  switch (verdict.route) {
    case Route::refused:
      hub_.log("a request was refused: " + verdict.reason);
      return reply(verdict.status, "text/plain; charset=utf-8", body_ = verdict.reason + "\n");
    case Route::file: {
      const PageFile file = page_file(verdict.path);
      constexpr int not_found = 404;
      if (file.text.empty())
        return reply(not_found, "text/plain; charset=utf-8", body_ = "there is no such file\n");
      return reply(verdict.status, file.type, file.text);
    }
    case Route::scene: return reply(verdict.status, "application/json", body_ = hub_.source().scene());
    case Route::frames:
      frames_ = hub_.source().recording();
      if (!frames_) return reply(verdict.status, "application/octet-stream", "");
      return reply(verdict.status, "application/octet-stream",
                   {reinterpret_cast<const char*>(frames_->data()), frames_->size()});
    case Route::stream:
    case Route::foxglove: break;
  }
  const http::request<http::empty_body> upgraded = parser_->release();
  hub_.upgrade(std::move(socket_), upgraded, verdict.route == Route::foxglove);
  hub_.forget(this);
}

void Requests::reply(int status, std::string_view type, std::string_view body) {
  response_ = {};
  response_.result(static_cast<unsigned>(status));
  const auto set = [this](const char* name, std::string_view value) {
    response_.set(name, beast::string_view(value.data(), value.size()));
  };
  set("Content-Type", type);
  set("Cache-Control", "no-store");
  set("Referrer-Policy", "no-referrer");  // because the address contains the token
  set("X-Content-Type-Options", "nosniff");
  set("Cross-Origin-Resource-Policy", "same-origin");
  set("Content-Security-Policy",
      "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; connect-src 'self' ws:; "
      "frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
  response_.keep_alive(parser_->get().keep_alive());
  response_.body() = {body.data(), body.size()};
  response_.prepare_payload();
  socket_.expires_after(silence_patience);
  http::async_write(socket_, response_, [self = shared_from_this()](Error error, std::size_t) {
    if (error || !self->response_.keep_alive()) return self->hub_.forget(self.get());
    self->read();
  });
}

/// Returns the line with at most max_line_bytes, and without control characters, because clients choose some
/// of its words.
std::string for_console(std::string line) {
  if (line.size() > max_line_bytes) line.replace(max_line_bytes, line.npos, "...");
  std::ranges::replace_if(
      line, [](char c) { return c < ' ' || c > '~'; }, '?');
  return line;
}

// --- the hub ----------------------------------------------------------------------------------------

std::string Hub::listen() {
  Error error;
  const net::ip::address address = net::ip::make_address(settings_.address, error);
  if (error)
    return "--view-address: '" + settings_.address + "' is no address of a machine, such as 127.0.0.1";
  const int first = settings_.port != 0 ? settings_.port : default_view_port;
  const int last = settings_.port != 0 ? first : first + num_default_ports - 1;
  for (int port = first; port <= last; ++port) {
    const tcp::endpoint place(address, static_cast<std::uint16_t>(port));
    Error closed;
    closed = acceptor_.close(closed);
    error = {};
    if (acceptor_.open(place.protocol(), error) ||
        acceptor_.set_option(net::socket_base::reuse_address(true), error) || acceptor_.bind(place, error) ||
        acceptor_.listen(net::socket_base::max_listen_connections, error))
      continue;
    port_ = static_cast<std::uint16_t>(port);
    door_.emplace(settings_.address, port_, settings_.token);
    return "";
  }
  return "--view: cannot listen on " + settings_.address + ", port " + std::to_string(first) +
         (last > first ? " to " + std::to_string(last) : std::string()) + ": " + error.message() +
         ". Give another port: --view PORT";
}

void Hub::run_thread() {
  accept();
  thread_ = std::thread([this] {
    const ThreadSetup setup("view");
    try {
      io_.run();
    } catch (const std::exception& error) {  // out of memory: the run continues without its view
      if (log_) log_(std::string("the view has ended: ") + error.what());
    }
  });
}

Hub::~Hub() {
  if (!thread_.joinable()) return;
  try {
    net::post(io_, [this] { say_farewell(); });
  } catch (const std::exception&) {  // out of memory: without a farewell
    io_.stop();
  }
  thread_.join();
}

void Hub::say_farewell() {
  ending_ = true;
  Error ignored;
  ignored = acceptor_.close(ignored);
  for (const auto& requests : requests_) requests->drop();
  for (const auto& stream : streams_) stream->close(websocket::close_code::going_away, "the run has ended");
  timer_.expires_after(farewell_patience);
  timer_.async_wait([this](Error) { io_.stop(); });
  if (streams_.empty()) io_.stop();
}

void Hub::accept() {
  acceptor_.async_accept([this](Error error, tcp::socket socket) {
    if (ending_) return;
    if (error) {  // out of descriptors: retried later
      accept_timer_.expires_after(std::chrono::milliseconds(100));
      return accept_timer_.async_wait([this](Error) { accept(); });
    }
    if (requests_.size() >= max_requests) {  // drops the oldest request
      log("a request was dropped: more than " + std::to_string(max_requests) + " at a time");
      requests_.front()->drop();
      requests_.pop_front();
    }
    error = socket.set_option(tcp::no_delay(true), error);
    requests_.push_back(std::make_shared<Requests>(std::move(socket), *this));
    requests_.back()->read();
    accept();
  });
}

void Hub::upgrade(beast::tcp_stream&& socket, const http::request<http::empty_body>& request, bool foxglove) {
  if (streams_.size() >= max_streams)
    return log("a client was refused: more than " + std::to_string(max_streams) + " are connected");
  streams_.push_back(std::make_shared<Stream>(std::move(socket), *this, next_id_++, foxglove));
  streams_.back()->accept(request);
}

void Hub::joined(Stream& stream) {
  if (FoxgloveClient* const foxglove = stream.foxglove()) {
    for (const std::string& text : foxglove->greeting(source_.scene())) stream.send(text_message(text));
  } else {
    stream.send(text_message(source_.scene()));
  }
  poll();
}

void Hub::forget(const Stream* stream) {
  source_.leave(stream->id());
  std::erase_if(streams_, [=](const auto& s) { return s.get() == stream; });
  if (ending_ && streams_.empty()) io_.stop();
}

void Hub::poll() {
  if (polling_ || ending_ || streams_.empty()) return;
  polling_ = true;
  timer_.expires_after(poll_period);
  timer_.async_wait([this](Error error) {
    polling_ = false;
    if (error || ending_) return;
    feed();
    poll();
  });
}

void Hub::feed() {
  const ViewBytes frame = source_.frame();
  const Clock::time_point now = Clock::now();
  const auto of_day = std::chrono::system_clock::now().time_since_epoch();
  const auto now_ns = static_cast<std::uint64_t>(std::chrono::nanoseconds(of_day).count());
  for (auto next = streams_.begin(); next != streams_.end();) {
    const std::shared_ptr<Stream> stream = *next++;  // the stream may be removed below
    if (stream->is_stalled(now)) {
      log("a client was closed: it accepted no bytes for " + std::to_string(write_patience.count()) + " s");
      stream->drop();
    } else if (FoxgloveClient* const foxglove = stream->foxglove()) {
      if (frame)
        foxglove->show(*frame, now_ns, [&](ViewBytes bytes) {
          return stream->offer({.binary = true, .bytes = std::move(bytes)});
        });
    } else if (frame) {
      static_cast<void>(stream->offer({.binary = true, .bytes = frame}));
    }
  }
}

void Hub::log(const std::string& line) {
  const Clock::time_point now = Clock::now();
  allowed_lines_ = std::min<double>(max_lines, allowed_lines_ + (now - last_allowed_) / line_period);
  last_allowed_ = now;
  if (allowed_lines_ < 1 || (line == last_line_ && now - last_logged_ < std::chrono::seconds(1))) {
    ++num_unsaid_;
    return;
  }
  --allowed_lines_;
  if (num_unsaid_ > 0 && log_) log_("and " + std::to_string(num_unsaid_) + " more like this");
  num_unsaid_ = 0;
  last_line_ = line;
  last_logged_ = now;
  if (log_) log_(for_console(line));
}

}  // namespace server

std::unique_ptr<ViewServer> ViewServer::start(const ServerSettings& settings, ViewSource& source, Log log,
                                              std::string& why_not) {
  auto hub = std::make_unique<server::Hub>(settings, source, std::move(log));
  why_not = hub->listen();
  if (!why_not.empty()) return nullptr;
  hub->run_thread();
  return hub;
}

}  // namespace godobject
