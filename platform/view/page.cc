#include "platform/view/page.h"

#include <array>

#ifdef GODOBJECT_PAGE_DIR
// The files as they were built, between two labels each.
#define GODOBJECT_EMBED(label, file)                                                                 \
  asm(".pushsection .rodata\n.global page_" label "\npage_" label ":\n.incbin \"" GODOBJECT_PAGE_DIR \
      "/" file "\"\n.global page_" label "_end\npage_" label "_end:\n.byte 0\n.popsection\n")
GODOBJECT_EMBED("html", "index.html");
GODOBJECT_EMBED("js", "app.js");
GODOBJECT_EMBED("css", "app.css");
GODOBJECT_EMBED("licences", "licences.txt");
extern "C" {
extern const char page_html[], page_html_end[], page_js[], page_js_end[], page_css[], page_css_end[],
    page_licences[], page_licences_end[];
}
#endif

namespace godobject {
namespace {

struct Row {
  std::string_view path;
  PageFile file;
};

#ifdef GODOBJECT_PAGE_DIR
std::string_view between(const char* begin, const char* end) noexcept {
  return {begin, static_cast<std::size_t>(end - begin)};
}

std::array<Row, 4> rows() noexcept {
  return {{{"/", {between(page_html, page_html_end), "text/html; charset=utf-8"}},
           {"/app.js", {between(page_js, page_js_end), "text/javascript; charset=utf-8"}},
           {"/app.css", {between(page_css, page_css_end), "text/css; charset=utf-8"}},
           {"/licences.txt", {between(page_licences, page_licences_end), "text/plain; charset=utf-8"}}}};
}
#else
constexpr std::string_view no_page =
    "This program was built without its page, which needs npm and esbuild:\n"
    "./dev setup view, then build again. Programs that speak foxglove.websocket.v1 can look on at /stream.\n";

std::array<Row, 1> rows() noexcept { return {{{"/", {no_page, "text/plain; charset=utf-8"}}}}; }
#endif

}  // namespace

PageFile page_file(std::string_view path) noexcept {
  for (const Row& row : rows())
    if (row.path == path) return row.file;
  return {};
}

bool has_page() noexcept { return rows().size() > 1; }

}  // namespace godobject
