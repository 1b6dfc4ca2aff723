// Recorded exchanges with NDI trackers, in the three formats of the shared folder.
#pragma once

#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace godobject::test {

/// One command and the received bytes, as on the wire.
struct NdiExchange {
  std::string command;  // without CR; empty for unsolicited bytes
  std::vector<std::uint8_t> reply;
};

inline std::string whole_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Reads "sent:0019 = ..." and "recv:0019 = ...", with LF where the wire has CR.
inline std::vector<NdiExchange> read_tagged_stream(const std::filesystem::path& path) {
  const std::string text = whole_file(path);
  std::vector<NdiExchange> all;
  std::string command;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t sent = text.find("sent:", at), received = text.find("recv:", at);
    const std::size_t begin = std::min(sent, received);
    if (begin == std::string::npos) break;
    const std::size_t content = begin + std::string("sent:0000 = ").size();
    std::size_t end = std::min(text.find("\nsent:", content), text.find("\nrecv:", content));
    if (end == std::string::npos) end = text.find_last_not_of("\n\r ") + 1;
    end = std::max(end, content);
    const std::string body = text.substr(content, end - content);
    if (begin == sent) {
      command = body;
    } else {
      all.push_back({.command = command, .reply = {body.begin(), body.end()}});
      all.back().reply.push_back('\r');
    }
    at = end;
  }
  return all;
}

/// Decodes `\xHH` and `\\` of the escaped format.
inline std::string unescaped(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\' || i + 1 >= text.size()) {
      out += text[i];
    } else if (text[i + 1] == 'x') {
      out += static_cast<char>(std::stoi(text.substr(i + 2, 2), nullptr, 16));
      i += 3;
    } else {
      out += text[++i];
    }
  }
  return out;
}

/// Reads "12. command[10] ..." and "12. receive[10] ...", with the number of bytes in brackets. A reply may
/// be split.
inline std::vector<NdiExchange> read_counted_stream(const std::filesystem::path& path, bool escaped) {
  const std::string text = whole_file(path);
  std::vector<NdiExchange> all;
  for (std::size_t at = 0;;) {
    const std::size_t sent = text.find(" command[", at), received = text.find(" receive[", at);
    const std::size_t begin = std::min(sent, received);
    if (begin == std::string::npos) return all;
    const std::size_t number = begin + std::string(" command[").size();
    const std::size_t close = text.find("] ", number);
    const auto size = static_cast<std::size_t>(std::stoul(text.substr(number, close - number)));
    std::string body = escaped ? unescaped(text.substr(close + 2, text.find('\n', close) - close - 2))
                               : text.substr(close + 2, size);
    body.resize(size);
    if (begin == sent) {
      all.push_back({.command = body.substr(0, body.find('\r')), .reply = {}});
    } else {
      if (all.empty()) all.emplace_back();
      all.back().reply.insert(all.back().reply.end(), body.begin(), body.end());
    }
    at = escaped ? close : close + 2 + size;
  }
}

}  // namespace godobject::test
