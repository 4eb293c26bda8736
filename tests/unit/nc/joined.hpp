#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "reading.hpp"

namespace trunnion::nc {

/// A file in the folder for temporary files, for as long as this is there.
class FileForTest {
  public:
    FileForTest(std::string_view name, std::string_view content)
        : path_(std::filesystem::temp_directory_path() / fmt::format("trunnion_parts_{}_{}", ::getpid(), name)) {
        std::ofstream(path_, std::ios::binary) << content;
    }
    FileForTest(const FileForTest&) = delete;
    FileForTest& operator=(const FileForTest&) = delete;
    ~FileForTest() { std::filesystem::remove(path_); }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

inline std::string bits(double value) {
    return std::isnan(value) ? "-" : fmt::format("{}", value);
}

template <class Values>
std::string all_bits(const Values& values) {
    std::string out;
    for (const double value : values) out += bits(value) + ' ';
    return out;
}

/// Everything that a move says, with its arc or curve, in words that do not depend on indices. Rotary words by letter.
inline std::string description(const program::Program& p, std::size_t index) {
    const program::Move& m = p.moves[index];
    std::string out = fmt::format("{} k{} s{} l{} x{} f{}:{} tool {} offset {} at {}", m.line, int(m.kind),
                                  int(m.space), int(m.law), int(m.exact_stop), int(m.feed.rule), m.feed.value,
                                  p.tools.at(m.tool), p.offsets.at(m.offset), all_bits(m.position_mm));
    if (m.law == program::OrientationLaw::vector) out += " axis " + all_bits(m.axis);
    for (std::size_t i = 0; i < p.rotary_letters.size() && m.law == program::OrientationLaw::rotary; ++i)
        out += fmt::format(" {}{}", p.rotary_letters[i], bits(m.rotary_rad[i]));
    if (m.arc != program::no_arc) {
        const program::Arc& arc = p.arcs.at(static_cast<std::size_t>(m.arc));
        out += fmt::format(" arc {} {} {}", all_bits(arc.centre_mm), all_bits(arc.normal), arc.angle_rad);
    }
    if (m.curve_part != program::no_curve_part) {
        const auto& part = p.curve_parts.at(static_cast<std::size_t>(m.curve_part));
        const program::Curve& curve = p.curves.at(static_cast<std::size_t>(part.curve));
        out += fmt::format(" curve {} {}…{} {} {} knots {}", curve.degree, part.from_u, part.to_u,
                           curve.position_mm.size(), all_bits(curve.position_mm.back()), all_bits(curve.knots));
        for (const auto& words : curve.rotary_rad)
            for (std::size_t i = 0; i < p.rotary_letters.size(); ++i) out += ' ' + bits(words[i]);
    }
    for (std::size_t i = 0; i < p.following_letters.size(); ++i)
        out += fmt::format(" {}{}", p.following_letters[i], p.following.at(index * p.following_letters.size() + i));
    return out;
}

/// A program as lines of text: moves, events, path controls and diagnostics, each in order.
struct Described {
    std::vector<std::string> moves, events, controls, told;
    std::size_t parts = 0;
    bool operator==(const Described& other) const {
        return moves == other.moves && events == other.events && controls == other.controls && told == other.told;
    }
};

/// Adds a part behind those before it. Of its first move only what lies in it counts: it is the last one's end.
inline void add(const program::Program& p, Described& all) {
    const std::size_t base = all.parts++ == 0 ? 0 : all.moves.size() - 1;
    for (std::size_t i = base == 0 ? 0 : 1; i < p.moves.size(); ++i) all.moves.push_back(description(p, i));
    for (const program::Event& e : p.events)
        all.events.push_back(fmt::format("{} {} {} {} {} {}", int(e.kind), e.stops_motion, e.dwell_s, e.word,
                                         e.before_move + base, e.line));
    const bool repeated = base > 0 && !p.path_controls.empty() && !all.controls.empty();
    for (std::size_t i = repeated ? 1 : 0; i < p.path_controls.size(); ++i) {
        const program::PathControl& c = p.path_controls[i];
        all.controls.push_back(
            fmt::format("{} {} {} {}", int(c.kind), c.tolerance_mm, c.merge_tolerance_mm, c.before_move + base));
    }
    for (const Diagnostic& d : p.diagnostics)
        all.told.push_back(fmt::format("{} {} {} {}", d.code, d.value, d.count, d.place.line));
}

/// All parts of a file, joined; the error behind the parts before it.
struct JoinedParts {
    Described joined;
    std::optional<Diagnostic> error;
    std::vector<program::Program> parts;
};

inline JoinedParts join_parts(const std::filesystem::path& file, const ReadOptions& options) {
    JoinedParts out;
    auto parts = open_program_file(file, options);
    if (!parts) {
        out.error = parts.error();
        return out;
    }
    program::Program part;
    for (;;) {
        const auto more = (*parts)->next(part);
        if (!more) out.error = more.error();
        if (!more || !*more) return out;
        add(part, out.joined);
        out.parts.push_back(part);
    }
}

}  // namespace trunnion::nc
