#pragma once

#include <string_view>

namespace trunnion::report::detail {

/// The parts of the page that are the same for all programs, bundled from the folder web/ when this program was built.
struct WebPage {
    std::string_view style, script;
    std::string_view policy;   ///< Content-Security-Policy: this style and this script, nothing from outside
    std::string_view missing;  ///< not empty: why the parts above are
};
const WebPage& web_page();

}  // namespace trunnion::report::detail
