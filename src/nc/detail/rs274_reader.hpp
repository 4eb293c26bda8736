#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/dialects.hpp"
#include "detail/findings.hpp"
#include "detail/rs274_block.hpp"
#include "detail/rs274_control.hpp"
#include "detail/rs274_words.hpp"

namespace trunnion::nc {

/// Of a coordinate that no block has said yet, or not in this frame: the axis stays where it stands.
inline constexpr double unknown_word = std::numeric_limits<double>::quiet_NaN();

using RotaryWords = std::array<double, program::max_rotary_letters>;

/// In what the linear words count. Of machine positions neither offset nor tool matter: they are 0.
struct Frame {
    program::Space space = program::Space::workpiece;
    std::uint16_t offset = 0, tool = 0;
    bool operator==(const Frame&) const = default;
};

/// The words that stay in force from block to block.
struct Modal {
    Meaning motion = Meaning::no_motion;
    bool absolute = true, centre_absolute = false, inverse_time = false, exact_stop = false, tcp = true;
    int plane_normal = 2;  ///< of X, Y, Z
    double unit_mm = 1;
    double feed_per_s = 0;  ///< F/60 in mm or inch as it was given; 0 = none
    double feed_unit_mm = 1;
    std::uint16_t offset = 0, tool = 0;
    std::optional<std::uint16_t> length_tool;  ///< of G43 H; else the tool in the spindle
    std::optional<double> prepared_tool;
};

/// The G and M words of one block by group.
struct Request {
    std::array<Meaning, static_cast<std::size_t>(Group::count)> meaning{};
    std::array<Code, static_cast<std::size_t>(Group::count)> code;
    std::optional<bool> tcp;
    bool own_word = false;  ///< one that the machine file lets pass, with whatever parameters it has

    Meaning of(Group group) const { return meaning[static_cast<std::size_t>(group)]; }
    const Code& code_of(Group group) const { return code[static_cast<std::size_t>(group)]; }
    bool asks(Group group, Meaning wanted) const { return of(group) == wanted; }
};

/// As people write it, `G59.1`.
inline std::string name_of(const Code& code) {
    return fmt::format("{}{:g}", code.letter, code.tenths / 10.0);
}

/// Carries out the blocks of a G-code program. rs274.cpp: words and modes; rs274_motion.cpp: where a block goes, how
/// fast, and which poses are kept; rs274_arc.cpp: circles.
class Rs274Reader {
  public:
    Rs274Reader(std::string_view text, std::string_view file_name, const ReadOptions& options, Control control)
        : findings_(file_name), scanner_(text, findings_), options_(options), control_(std::move(control)) {
        program_.source = file_name;
        program_.name = std::filesystem::path(file_name).stem().string();
        program_.dialect = nc::name_of(Dialect::rs274);
        program_.offsets.emplace_back("G54");  // in force when a program starts
        program_.moves.reserve(text.size() / 64 + 1);
        modal_.offset = 1;
        modal_.unit_mm = options.units == Units::inch ? inch_mm : 1;
        position_mm_.setConstant(unknown_word);
        rotary_rad_.fill(unknown_word);
    }

    Result<program::Program> read();

  private:
    bool block();
    bool sort_codes();
    bool own_code(const Code& code);
    bool sort_code(const Code& code);
    bool check_letters();
    bool check_letter(char letter);
    bool absent_axis(char letter);
    void feed_mode();
    bool feed();
    bool spindle_and_tool();
    bool change_tool();
    bool dwell();
    void units();
    bool modes();
    bool path_control();
    bool offset();
    bool tool_length();
    Meaning motion_in_force() const;
    bool moves_on_arc() const;
    bool motion();
    void enter(const Frame& frame);
    bool target();
    bool axis_word(char letter);
    bool arc_from(Eigen::Vector3d start_mm, program::Move& move);
    bool check_arc_words();
    Eigen::Vector3d centre_from(const Eigen::Vector3d& start_mm) const;
    bool turns_only(const program::Move& move) const;
    bool feed_of(program::Move& move);
    bool add(program::Move& move);
    void stops();
    bool never_started();
    Result<program::Program> done();
    void drop_undetermined();
    void keep_used_letters();
    void event(program::EventKind kind, bool stops, std::string word, double dwell_s = 0) {
        program_.events.push_back({kind, stops, dwell_s, std::move(word), program_.moves.size(), block_.line});
    }
    void code_event(program::EventKind kind, bool stops, Group group) {
        event(kind, stops, name_of(request_.code_of(group)));
    }
    bool refuse(std::string_view code, Spot spot, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, spot, std::move(text), value, hint);
    }
    /// The first axis word, else the word that asks for the motion, else a letter of the arc.
    Spot spot_of_motion() const {
        if (axes_ == 0 && request_.of(Group::motion) != Meaning::unknown)
            return {block_.line, request_.code_of(Group::motion).column};
        const std::uint32_t letters = axes_ != 0 ? axes_ : block_.present;
        return {block_.line, block_.column[static_cast<std::size_t>(std::countr_zero(letters))]};
    }

    Findings findings_;
    BlockScanner scanner_;
    const ReadOptions& options_;
    Control control_;
    program::Program program_;
    Block block_;
    Request request_;
    Modal modal_;
    UnitStatement stated_;
    std::uint32_t axes_ = 0;  ///< axis letters of the block
    std::uint32_t axes_ever_ = 0;
    Frame frame_;
    Eigen::Vector3d position_mm_;  ///< in frame_; unknown until said
    RotaryWords rotary_rad_;       ///< by the machine's rotary axes; unknown until said
    bool finished_ = false;
};

}  // namespace trunnion::nc
