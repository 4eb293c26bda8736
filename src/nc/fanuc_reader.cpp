#include "detail/dialects.hpp"

namespace trunnion::nc {

bool is_fanuc_line(std::string_view) noexcept {
    return false;
}

Result<program::Program> read_fanuc(std::string_view, std::string_view file_name, const ReadOptions&) {
    return fail(Diagnostic{.code = "NC0004", .text = "not read yet", .place = {.file = std::string(file_name)}});
}

}  // namespace trunnion::nc
