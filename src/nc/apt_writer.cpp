#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

#include "detail/program_writer.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Space;

namespace {

/// CL data. Positions are said whole in every GOTO, the vector where it changes.
class AptWriter final : public ProgramWriter {
  public:
    using ProgramWriter::ProgramWriter;

  private:
    void head() override {
        statement("PARTNO/" + plain(program_.name.empty() ? "PROGRAM" : program_.name));
        for (const std::string& text : options_.head) comment(text);
        statement(options_.units == Units::inch ? "UNITS/INCHES" : "UNITS/MM");
        statement("MULTAX/ON");
    }

    void tail() override { statement("FINI"); }

    bool enter(const Move& to) override {
        if (to.space != Space::workpiece)
            return refuse("NC0903", "a move with TCP off: CL data has poses of the tool alone", {},
                          "write it in another dialect, or leave it out");
        if (to.law == OrientationLaw::rotary && !program_.rotary_letters.empty())
            return refuse("NC0902", "rotary words: CL data has tool vectors alone", {},
                          "with a machine (-m) rotary words become vectors");
        if (to.exact_stop) tell("NC0914", "exact stop", "CL data has no word for an exact stop: left out");
        const std::string& offset = offset_name(to);
        if (!offset.empty() && offset != "G54")
            return refuse("NC0905", "CL data has no work offsets", offset, "give one program for each");
        return load(tool_name(to));
    }

    bool load(const std::string& name) {
        if (name == loaded_) return true;
        if (name.find_first_of(" ,/$") != name.npos)
            return refuse("NC0906", "a tool that CL data cannot call", name, "tools are numbers or plain names here");
        statement("LOADTL/" + name);
        loaded_ = name;
        return true;
    }

    bool straight(const Move& to) override {
        if (to.kind == MoveKind::rapid) statement("RAPID");
        feed(to, false);
        go_to(to);
        return true;
    }

    void go_to(const Move& to) {
        out_.put("GOTO/");
        for (std::size_t i = 0; i < 3; ++i) {
            if (i > 0) out_.put(',');
            out_.number(linear_grid_, goal_.linear[i]);
        }
        if (turns_vector())
            for (const std::int64_t steps : goal_.axis) {
                out_.put(',');
                out_.number(vector_grid_, steps);
            }
        out_.end_line();
        arrive(to);
    }

    void feed(const Move& to, bool on_arc) {
        const FeedWord word = feed_word(to, on_arc, false, feed_of_turns_counts_for_nothing);
        if (word.kind == FeedWord::Kind::none || word.number == feed_) return;
        feed_ = word.number;
        out_.put("FEDRAT/");
        out_.number_within(word.number, options_.feed_precision);
        out_.put(options_.units == Units::inch ? ",IPM" : ",MMPM");
        out_.end_line();
    }

    /// MOVARC: one GOTO ends it, in the sense and with the turns that ANGLE says.
    bool arc(const Move& to) override {
        const program::Arc& arc = program_.arcs[static_cast<std::size_t>(to.arc)];
        const Vector3d start = said_mm() - arc.centre_mm, end = goal_mm() - arc.centre_mm;
        const double first = start.cross(arc.normal).norm(), last = end.cross(arc.normal).norm();
        constexpr double least_arm_mm = 0.1;
        if (!(std::abs(first - last) <= 4 * options_.precision_mm) || !(first > least_arm_mm)) return false;
        if (!(std::abs(arc.angle_rad) * first > 10 * options_.precision_mm) || to.kind == MoveKind::rapid) return false;
        feed(to, true);
        const DecimalGrid finer = DecimalGrid::within(0.01 * options_.precision_mm / unit_mm());
        const DecimalGrid direction = DecimalGrid::within(1e-12), angle = DecimalGrid::within(1e-6);
        const Vector3d foot = arc.centre_mm / unit_mm();
        if (!finer.holds(foot.cwiseAbs().maxCoeff())) return false;
        out_.put("MOVARC/");
        for (int i = 0; i < 3; ++i) {
            out_.number(finer, finer.steps(foot[i]));
            out_.put(',');
        }
        for (int i = 0; i < 3; ++i) {
            out_.number(direction, direction.steps(arc.normal[i]));
            out_.put(',');
        }
        out_.number(finer, finer.steps(first / unit_mm()));
        out_.put(",ANGLE,");
        out_.number(angle, angle.steps(arc.angle_rad / degree));
        out_.end_line();
        go_to(to);
        return true;
    }

    bool action(const Action& action, const program::Event& event) override {
        using Kind = Action::Kind;
        switch (action.kind) {
            case Kind::dwell:
                out_.put("DELAY/");
                out_.number_within(action.number, options_.feed_precision);
                out_.end_line();
                return true;
            case Kind::spindle_speed:
                speed_ = fmt::format("{},RPM,", action.number);
                return sense_.empty() || spindle(sense_);
            case Kind::spindle_clockwise:
                return spindle("CLW");
            case Kind::spindle_counter_clockwise:
                return spindle("CCLW");
            case Kind::spindle_off:
                sense_ = {};
                return say("SPINDL/OFF");
            case Kind::mist:
                return say("COOLNT/MIST");
            case Kind::flood:
                return say("COOLNT/FLOOD");
            case Kind::coolant_off:
                return say("COOLNT/OFF");
            case Kind::pause:
                return say("STOP");
            case Kind::optional_pause:
                return say("OPSTOP");
            case Kind::end:
                return say("END");
            case Kind::prepare_tool:
                prepared_ = action.name;
                return true;
            default:
                return change_tool(action, event);
        }
    }

    /// A speed alone would start the spindle: it is said with the sense.
    bool spindle(std::string_view sense) {
        sense_ = sense;
        return say(fmt::format("SPINDL/{}{}", speed_, sense));
    }

    bool change_tool(const Action& action, const program::Event& event) {
        std::string name(action.name.empty() ? prepared_.value_or("") : std::string(action.name));
        if (name.empty() || name.find_first_of(" ,/$") != name.npos) return false;
        statement(is_own("apt") ? event.word : "LOADTL/" + name);
        loaded_ = std::move(name);
        return true;
    }

    bool own_word(const program::Event& event) override { return say(event.word); }

    void comment(std::string_view text) override { statement("PPRINT/" + plain(text)); }

    bool say(std::string_view text) {
        statement(text);
        return true;
    }
    void statement(std::string_view text) {
        out_.put(text);
        out_.end_line();
    }
    static std::string plain(std::string_view text) {
        std::string out(text);
        for (char& c : out)
            if (c < ' ' || c > '~' || c == '$') c = '?';
        return out;
    }

    std::string loaded_, speed_;
    std::string_view sense_;  ///< of the spindle; empty: it stands
    std::optional<std::string> prepared_;
    double feed_ = 0;
};

}  // namespace

std::unique_ptr<ProgramWriter> make_apt_writer(const program::Program& program, const machine::Machine* machine,
                                               const WriteOptions& options, const TextSink& sink) {
    return std::make_unique<AptWriter>(program, machine, options, sink);
}

}  // namespace trunnion::nc
