// Access control: by host name, page and token.
#include "platform/view/server/server.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace godobject::test_door {
namespace {

const std::string token = "0123456789abcdef0123456789abcdef";

KnockHead page_of(std::string_view target) {
  return {.method = "GET", .target = target, .host = "127.0.0.1:7780"};
}

class DoorTest : public testing::Test {
 protected:
  Door door{"127.0.0.1", 7780, token};
  std::string stream = "/stream?token=" + token;

  Verdict stream_for(std::optional<std::string_view> origin, std::string_view protocols = stream_protocol) {
    KnockHead head = page_of(stream);
    head.origin = origin;
    head.upgrade = true;
    head.protocols = protocols;
    return door.judge(head);
  }
};

TEST_F(DoorTest, FilesAreForWhoeverNamesThisMachine) {
  EXPECT_EQ(door.judge(page_of("/")).route, Route::file);
  EXPECT_EQ(door.judge(page_of("/app.js?x=1")).path, "/app.js");
  KnockHead head = page_of("/");
  for (const char* host : {"localhost:7780", "127.0.0.1:7780", "[::1]:7780"}) {
    head.host = host;
    EXPECT_EQ(door.judge(head).route, Route::file) << host;
  }
  for (const char* host : {"", "evil.example:7780", "127.0.0.1", "127.0.0.1:80",
                           "localhost.evil.example:7780", "192.168.0.1:7780", "127.evil:7780"}) {
    head.host = host;
    EXPECT_EQ(door.judge(head).status, 403) << host;
  }
}

TEST_F(DoorTest, DataNeedsTheToken) {
  EXPECT_EQ(door.judge(page_of("/scene?token=" + token)).route, Route::scene);
  EXPECT_EQ(door.judge(page_of("/frames?a=b&token=" + token)).route, Route::frames);
  for (const std::string& query :
       std::vector<std::string>{"", "?token=", "?token=" + token.substr(1), "?token=" + token + "0",
                                "?tokens=" + token, "?token=1123456789abcdef0123456789abcdef"})
    EXPECT_EQ(door.judge(page_of("/scene" + query)).status, 403) << query;
  EXPECT_EQ(Door("127.0.0.1", 7780, "").judge(page_of("/scene?token=")).status, 403)
      << "no token opens nothing";
}

TEST_F(DoorTest, AStreamIsForItsOwnPage) {
  EXPECT_EQ(stream_for("http://127.0.0.1:7780").route, Route::stream);
  EXPECT_EQ(stream_for(std::nullopt).route, Route::stream) << "no browser";
  for (const char* origin : {"https://127.0.0.1:7780", "http://evil.example", "http://127.0.0.1:7781", "null",
                             "http://localhost:7780"})
    EXPECT_EQ(stream_for(origin).status, 403) << origin;
  EXPECT_EQ(stream_for(std::nullopt, "chat").status, 426);
  EXPECT_EQ(door.judge(page_of(stream)).status, 426) << "no upgrade";
}

TEST_F(DoorTest, FoxglovesPagesAreOthersAndHaveTheToken) {
  EXPECT_EQ(stream_for("https://app.example", foxglove_protocol).route, Route::foxglove);
  EXPECT_EQ(stream_for("https://app.example", "x, foxglove.websocket.v1 ,y").route, Route::foxglove);
  stream = "/stream";
  EXPECT_EQ(stream_for("https://app.example", foxglove_protocol).status, 403);
}

TEST_F(DoorTest, OnlyGetIsAnswered) {
  for (const char* method : {"POST", "PUT", "OPTIONS", "HEAD", "CONNECT"}) {
    KnockHead head = page_of("/");
    head.method = method;
    EXPECT_EQ(door.judge(head).status, 405) << method;
  }
}

TEST_F(DoorTest, OnAnAddressForOthersItIsNamedByNumbers) {
  const Door open("0.0.0.0", 7780, token);
  KnockHead head = page_of("/");
  head.host = "192.168.0.7:7780";
  EXPECT_EQ(open.judge(head).route, Route::file);
  head.host = "rebound.example:7780";
  EXPECT_EQ(open.judge(head).status, 403);
}

TEST(Token, IsKeptForThisUserAlone) {
  std::string folder = (std::filesystem::path(testing::TempDir()) / "godobject-XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
  const std::string first = view_token();
  EXPECT_EQ(first.size(), 32u);
  EXPECT_EQ(view_token(), first) << "the next run has the same";
  const std::string file = folder + "/godobject/view-token";
  struct stat status {};
  ASSERT_EQ(stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, 0600u);
  chmod(file.c_str(), 0644);
  EXPECT_NE(view_token(), first) << "one that others could read is not used";
  chmod(file.c_str(), 0600);
  std::ofstream(file) << "short";
  EXPECT_EQ(view_token().size(), 32u) << "what is no token is replaced";
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace godobject::test_door
