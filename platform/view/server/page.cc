#include "platform/view/server/server.h"

#include <array>
#include <cstdint>

#ifdef GODOBJECT_PAGE_DIR
// Embeds the built files, each with its size.
#define GODOBJECT_EMBED(label, file)                                                                 \
  asm(".pushsection .rodata\n.global page_" label "\npage_" label ":\n.incbin \"" GODOBJECT_PAGE_DIR \
      "/" file "\"\n1:\n.balign 8\n.global page_" label "_size\npage_" label                         \
      "_size:\n.quad "                                                                               \
      "1b - page_" label "\n.popsection\n")
GODOBJECT_EMBED("html", "index.html");
GODOBJECT_EMBED("js", "app.js");
GODOBJECT_EMBED("css", "app.css");
GODOBJECT_EMBED("licences", "licences.txt");
extern "C" {
extern const char page_html[], page_js[], page_css[], page_licences[];
extern const std::uint64_t page_html_size, page_js_size, page_css_size, page_licences_size;
}
#endif

namespace godobject {
namespace {

struct Row {
  std::string_view path;
  PageFile file;
};

#ifdef GODOBJECT_PAGE_DIR
std::array<Row, 4> rows() noexcept {
  return {{{"/", {{page_html, page_html_size}, "text/html; charset=utf-8"}},
           {"/app.js", {{page_js, page_js_size}, "text/javascript; charset=utf-8"}},
           {"/app.css", {{page_css, page_css_size}, "text/css; charset=utf-8"}},
           {"/licences.txt", {{page_licences, page_licences_size}, "text/plain; charset=utf-8"}}}};
}
#else
constexpr std::string_view no_page =
    "This program was built without its page, which needs npm and esbuild:\n"
    "./dev setup view, then build again. Programs with foxglove.websocket.v1 can connect to /stream.\n";

std::array<Row, 1> rows() noexcept { return {{{"/", {no_page, "text/plain; charset=utf-8"}}}}; }
#endif

}  // namespace

PageFile page_file(std::string_view path) noexcept {
  for (const Row& row : rows())
    if (row.path == path) return row.file;
  return {};
}

bool has_page() noexcept { return rows().size() > 1; }

#ifdef GODOBJECT_NO_BOOST  // replaces server.cc
std::unique_ptr<ViewServer> ViewServer::start(
    const ServerSettings& /*settings*/, ViewSource& /*source*/,
    Log /*log*/,  // NOLINT(performance-unnecessary-value-param): server.cc stores it
    std::string& why_not) {
  why_not =
      "view: this program was built without Boost, which its server needs: ./dev setup view (or apt-get "
      "install "
      "libboost1.81-dev), then build again. Pictures need no server: godobject view FILE --picture FILE.png";
  return nullptr;
}
#endif

}  // namespace godobject
