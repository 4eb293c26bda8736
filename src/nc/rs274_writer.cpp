#include <algorithm>
#include <optional>
#include <string>

#include "detail/g_code_writer.hpp"

namespace trunnion::nc {

using program::Move;
using program::OrientationLaw;
using program::PathControl;
using program::PathControlKind;
using program::Space;

namespace {

bool is_number(std::string_view name) {
    return !name.empty() && name.find_first_not_of("0123456789") == name.npos;
}

/// G-code as LinuxCNC takes it. The tool whose length counts is that in the spindle, else it is said by G43 H.
class Rs274Writer final : public GCodeWriter {
  public:
    Rs274Writer(const program::Program& program, const machine::Machine* machine, const WriteOptions& options,
                const TextSink& sink)
        : GCodeWriter(program, machine, options, sink, Habits{.arcs = arcs_of(options)}) {
        if (!machine || machine->rotary_count == 0) return;
        const auto& words = machine->words;
        const bool declared = !words.tcp_on.empty() || !words.tcp_off.empty();
        tcp_on_ = declared ? (words.tcp_on.empty() ? "" : words.tcp_on.front()) : "M428";
        tcp_off_ = declared ? (words.tcp_off.empty() ? "" : words.tcp_off.front()) : "M429";
    }

  private:
    static const ArcTolerance& arcs_of(const WriteOptions& options) {
        return options.units == Units::inch ? linuxcnc_inch_arcs : linuxcnc_arcs;
    }

    void head() override {
        head_comments();
        line(options_.units == Units::inch ? "G20 G90 G94 G17 G40 G54" : "G21 G90 G94 G17 G40 G54");
    }

    void tail() override {
        if (!ends_itself()) line("M2");
    }

    bool takes_following() const override { return true; }

    bool enter(const Move& to) override {
        if (to.law == OrientationLaw::vector && !(to.axis.z() > 1 - 1e-15 && !has_rotary_axes()))
            return refuse("NC0902", "a tool vector: this dialect has rotary words alone", {},
                          "with a machine (-m) vectors become its rotary words");
        exact_stop(to);
        if (space_ != to.space) forget_linear();
        space_ = to.space;
        if (to.space == Space::machine) return count_tool(to, true);
        return count_tool(to, false) && transform(to.space == Space::workpiece) && count_offset(to);
    }

    bool has_rotary_axes() const { return machine_ && machine_->rotary_count > 0; }

    /// Said before the first move too. Without rotary axes both are the same.
    bool transform(bool on) {
        if (tcp_ == on) return true;
        const std::string& word = on ? tcp_on_ : tcp_off_;
        const bool matters = has_rotary_axes() || !program_.rotary_letters.empty();
        if (word.empty() && matters && (tcp_ || !on))
            return refuse("NC0903", on ? "TCP on, and no word for it" : "TCP off, and no word for it", {},
                          "the machine file (-m) says which: [words] tcp_on, tcp_off");
        if (!word.empty()) line(word);
        if (tcp_) forget_linear();
        tcp_ = on;
        return true;
    }

    bool count_offset(const Move& to) {
        if (to.offset == offset_) return true;
        const std::string& name = offset_name(to);
        const std::string_view wanted = name.empty() ? std::string_view("G54") : std::string_view(name);
        constexpr std::string_view known[] = {"G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"};
        if (std::find(std::begin(known), std::end(known), wanted) == std::end(known))
            return refuse("NC0905", "no such work offset in this dialect", name, "G54 … G59.3 are there");
        if (wanted != offset_word_) {
            line(wanted);
            forget_linear();
        }
        offset_word_ = wanted;
        offset_ = to.offset;
        return true;
    }

    bool count_tool(const Move& to, bool in_machine) {
        const std::string& name = tool_name(to);
        const std::string& counted = called_ ? *called_ : spindle_;
        if (name == counted || (in_machine && name == spindle_)) return true;
        const bool off = name.ends_with(" D0");
        if (name == spindle_) {
            line("G43");
            called_.reset();
        } else if (off ? name.substr(0, name.size() - 3) == spindle_ : is_number(name)) {
            line(off ? std::string("G43 H0") : "G43 H" + name);
            called_ = name;
        } else {
            return refuse("NC0906", "a tool whose length cannot be called in this dialect", name,
                          "tools are numbers here");
        }
        forget_linear();
        return true;
    }

    // Exact stop is modal here: where the program has no words of path control it is said before and behind.
    void exact_stop(const Move& to) {
        if (to.exact_stop == exact_stop_) return;
        exact_stop_ = to.exact_stop;
        line(exact_stop_ ? "G61.1" : "G64");
    }

    void path_control(const PathControl& control) override {
        exact_stop_ = control.kind != PathControlKind::blend;
        if (exact_stop_) return line(control.kind == PathControlKind::stop ? "G61.1" : "G61");
        begin_block();
        out_.gap();
        out_.put("G64");
        const auto length = [&](std::string_view letter, double mm) {
            out_.put(letter);
            out_.number_within(mm / unit_mm(), options_.feed_precision);
        };
        if (control.tolerance_mm > 0) length(" P", control.tolerance_mm);
        if (control.tolerance_mm > 0 && control.merge_tolerance_mm != control.tolerance_mm)
            length(" Q", control.merge_tolerance_mm);
        out_.end_line();
    }

    void words_before_motion(const Move& to) override {
        if (to.space == Space::machine) {
            out_.gap();
            out_.put("G53");
        }
    }

    void turn_words(int turns) override {
        out_.gap();
        out_.put('P');
        out_.integer(turns + 1);
    }

    void dwell(double seconds) override {
        begin_block();
        out_.gap();
        out_.put("G4 P");
        out_.number_within(seconds, options_.feed_precision);
        out_.end_line();
    }

    bool prepare_tool(std::string_view name) override {
        if (!is_number(name)) return false;
        prepared_ = name;
        line("T" + *prepared_);
        return true;
    }

    bool change_tool(std::string_view name) override {
        if (!name.empty() && !prepare_tool(name)) return false;
        line("M6");
        if (prepared_ && spindle_ != *prepared_) {
            spindle_ = *prepared_;
            if (!called_) forget_linear();
        }
        return true;
    }

    std::string tcp_on_, tcp_off_;
    std::optional<bool> tcp_;
    Space space_ = Space::workpiece;
    std::optional<std::uint16_t> offset_;
    std::string offset_word_ = "G54";
    std::string spindle_;
    std::optional<std::string> prepared_, called_;  ///< by T; by G43 H
    bool exact_stop_ = false;
};

}  // namespace

std::unique_ptr<ProgramWriter> make_rs274_writer(const program::Program& program, const machine::Machine* machine,
                                                 const WriteOptions& options, const TextSink& sink) {
    return std::make_unique<Rs274Writer>(program, machine, options, sink);
}

}  // namespace trunnion::nc
