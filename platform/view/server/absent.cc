// Replaces server.cc in builds without Boost.
#include "platform/view/server/server.h"

namespace godobject {

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

}  // namespace godobject
