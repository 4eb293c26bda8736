#include "trunnion/machine/machine.hpp"

namespace trunnion::machine {

const Tool* Setup::tool_named(std::string_view name) const {
    static const Tool without_length{};
    if (name.ends_with(" D0")) return &without_length;
    const auto found = tools.find(std::string(name));
    return found != tools.end() ? &found->second : nullptr;
}

}  // namespace trunnion::machine
