#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "trunnion/nc/read.hpp"
#include "trunnion/program/program_parts.hpp"

#include "detail/block_reader.hpp"
#include "detail/text_file.hpp"

namespace trunnion::nc {

/// Reads a text block by block until a part of its program is complete: every call of next() goes on where the one
/// before stopped. Nothing runs between the calls.
class ReadParts final : public program::ProgramParts {
  public:
    /// `text` is read, with a byte-order mark or without; it outlives this, or is the one of `file`.
    static Result<std::unique_ptr<ReadParts>> open(ProgramText text, std::optional<TextFile> file,
                                                   std::string_view file_name, const ReadOptions& options);

    Result<bool> next(program::Program& part) override;

  private:
    enum class Said : std::uint8_t { not_looked_for, never, perhaps };

    ReadParts(std::optional<TextFile> file, const ReadOptions& options) : file_(std::move(file)), options_(options) {}

    std::optional<std::size_t> end_of_part();
    bool can_end(std::size_t move);
    bool stands_behind(std::size_t move) const;
    bool is_known(const program::Move& move);
    bool may_be_said(std::size_t axis);
    void leave_open(const program::Move& move);
    bool check_letters();
    bool check_block();
    Result<bool> refused(Diagnostic diagnostic);
    Result<bool> last_part(program::Program& part);
    Result<bool> part_up_to(std::size_t last, program::Program& part);
    std::optional<Diagnostic> nul_byte() const;

    std::optional<TextFile> file_;
    ReadOptions options_;
    std::unique_ptr<BlockReader> reader_;
    std::size_t looked_at_ = 1;  ///< moves before this one do not end the part
    bool started_ = false, ended_ = false;
    std::optional<Diagnostic> error_;
    std::array<Said, program::max_rotary_letters> said_{};       ///< of axes of which no word was carried out
    std::array<bool, program::max_rotary_letters> left_open_{};  ///< a part has ended where the axis was not known
};

}  // namespace trunnion::nc
