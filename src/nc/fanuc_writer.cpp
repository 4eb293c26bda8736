#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "detail/g_code_writer.hpp"

namespace trunnion::nc {

using program::Move;
using program::OrientationLaw;
using program::Space;

namespace {

/// ISO code for FANUC and its like: G43.4 for rotary words, G43.5 for tool vectors (I J K), G43 and G49 with TCP off.
/// Every number has its point.
class FanucWriter final : public GCodeWriter {
  public:
    FanucWriter(const program::Program& program, const machine::Machine* machine, const WriteOptions& options,
                const TextSink& sink)
        : GCodeWriter(program, machine, options, sink, Habits{.numbers = {.point_always = true}}) {}

  private:
    /// What G43 … G49 have switched to.
    enum class Tcp : std::uint8_t { unsaid, off, by_words, by_vectors };

    void head() override {
        line("%");
        line("O0001");
        head_comments();
        line(options_.units == Units::inch ? "G20 G90 G94 G17 G40 G80 G49" : "G21 G90 G94 G17 G40 G80 G49");
    }

    void tail() override {
        if (!ends_itself()) line("M30");
        out_.put("%");
        out_.end_line();
    }

    bool enter(const Move& to) override {
        if (to.space != space_) {
            forget_linear();
            forget_axis();
        }
        space_ = to.space;
        if (to.space == Space::machine) return true;
        if (!count_offset(to)) return false;
        if (to.space == Space::untransformed) return transform(Tcp::off, to);
        return transform(to.law == OrientationLaw::vector ? Tcp::by_vectors : Tcp::by_words, to);
    }

    bool count_offset(const Move& to) {
        if (to.offset == offset_) return true;
        const std::string& name = offset_name(to);
        const std::string word = name.empty() ? "G54" : name;
        const bool plain = word.size() == 3 && word >= "G54" && word <= "G59";
        if (!plain && !word.starts_with("G54.1 P"))
            return refuse("NC0905", "no such work offset in this dialect", name, "G54 … G59 and G54.1 P1 … are there");
        line(word);
        offset_ = to.offset;
        forget_linear();
        forget_axis();
        return true;
    }

    /// The tool's length counts by its number, with TCP off too.
    bool transform(Tcp wanted, const Move& to) {
        const std::string& name = tool_name(to);
        if (tcp_ == wanted && name == counted_) return true;
        const bool length_off = name.ends_with(" D0");
        if (!length_off && name.find_first_not_of("0123456789") != name.npos)
            return refuse("NC0906", "a tool whose length cannot be called in this dialect", name,
                          "tools are numbers here");
        const std::string length = name.empty() ? "1" : name;
        const bool on = wanted != Tcp::off;
        if (length_off && on)
            return refuse("NC0906", "TCP with a tool whose length does not count", name, "call the tool's length");
        if (tcp_ == Tcp::by_words || tcp_ == Tcp::by_vectors) line("G49");
        if (on) line((wanted == Tcp::by_words ? "G43.4 H" : "G43.5 H") + length);
        if (!on && !length_off && !name.empty()) line("G43 H" + length);
        if (!on && length_off && tcp_ == Tcp::off) line("G49");
        tcp_ = wanted;
        counted_ = name;
        forget_linear();
        forget_axis();
        return true;
    }

    void words_before_motion(const Move& to) override {
        if (to.exact_stop) {
            out_.gap();
            out_.put("G09");
        }
        if (to.space != Space::machine) return;
        out_.gap();
        out_.put("G53");
    }

    void vector_words() override {
        constexpr std::string_view names[] = {"I", "J", "K"};
        for (std::size_t i = 0; i < 3; ++i) word(names[i], vector_grid_, goal_.axis[i]);
    }

    /// I J K are the tool's under G43.5.
    bool arc(const Move& to) override { return to.law != OrientationLaw::vector && GCodeWriter::arc(to); }
    bool takes_turns() const override { return false; }

    void dwell(double seconds) override {
        begin_block();
        out_.gap();
        out_.put("G4 X");
        out_.number_within(seconds, options_.feed_precision, habits_.numbers);
        out_.end_line();
    }

    bool prepare_tool(std::string_view name) override {
        if (name.empty() || name.find_first_not_of("0123456789") != name.npos) return false;
        line(fmt::format("T{}", name));
        return true;
    }

    bool change_tool(std::string_view name) override {
        if (!name.empty() && !prepare_tool(name)) return false;
        line("M6");
        return true;
    }

    std::optional<std::uint16_t> offset_;
    Space space_ = Space::untransformed;
    Tcp tcp_ = Tcp::unsaid;
    std::string counted_;
};

}  // namespace

std::unique_ptr<ProgramWriter> make_fanuc_writer(const program::Program& program, const machine::Machine* machine,
                                                 const WriteOptions& options, const TextSink& sink) {
    return std::make_unique<FanucWriter>(program, machine, options, sink);
}

}  // namespace trunnion::nc
