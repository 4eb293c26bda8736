#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "trunnion/nc/write.hpp"

#include "detail/action_writer.hpp"
#include "detail/findings.hpp"
#include "detail/text_writer.hpp"

namespace trunnion::nc {

/// Of a coordinate that the text has not said, or not in the frame in force.
inline constexpr std::int64_t unsaid = std::numeric_limits<std::int64_t>::min();

/// Walks through a program and has a dialect write it. Keeps what the reader of the text will know at every place.
class ProgramWriter {
  public:
    ProgramWriter(const program::Program& program, const machine::Machine* machine, const WriteOptions& options,
                  const TextSink& sink);
    virtual ~ProgramWriter() = default;
    ProgramWriter(const ProgramWriter&) = delete;
    ProgramWriter& operator=(const ProgramWriter&) = delete;

    Result<WriteSummary> write();

  protected:
    using Move = program::Move;

    virtual void head() = 0;
    virtual void tail() = 0;
    /// Everything that counts before the words of a move do: space, offset, tool, orientation law.
    virtual bool enter(const Move& move) = 0;
    /// A straight move to a place that is known on the grid: goal_.
    virtual bool straight(const Move& to) = 0;
    /// An arc to goal_; false and nothing written: it cannot be said, and is divided.
    virtual bool arc(const Move& to) = 0;
    /// The moves of one curve from moves[first] on; how many were written, 0: none can be, they are divided.
    virtual std::size_t curve(std::size_t) { return 0; }
    /// What an event asks for, in the dialect's words; false: it has none.
    virtual bool action(const Action& action, const program::Event& event) = 0;
    /// An event of a program of this dialect, as it stands there; false: it takes more than the word.
    virtual bool own_word(const program::Event& event) = 0;
    virtual void path_control(const program::PathControl&) {}
    /// Whether the dialect has axes that go along: Program::following_letters.
    virtual bool takes_following() const { return false; }
    /// The following axes go to following_mm_ while the path stands, or their counting changes; false: another event.
    virtual bool following_event(const program::Event&) { return false; }
    virtual void comment(std::string_view text) = 0;

    bool refuse(std::string_view code, std::string text, std::string_view value = {}, std::string_view hint = {}) {
        return findings_.refuse(code, {line_, 0}, std::move(text), value, hint);
    }
    void tell(std::string_view code, std::string_view what, std::string_view text, std::string_view hint = {}) {
        findings_.count(code, Severity::warning, {line_, 0}, what, text, hint);
    }
    bool is_own(std::string_view dialect) const { return program_.dialect == dialect; }
    bool ends_itself() const { return ended_; }

    double unit_mm() const { return unit_mm_; }
    const std::string& tool_name(const Move& move) const { return program_.tools[move.tool]; }
    const std::string& offset_name(const Move& move) const { return program_.offsets[move.offset]; }

    /// Where a move ends, on the grids; unsaid: it does not say.
    struct Goal {
        std::array<std::int64_t, 3> linear{unsaid, unsaid, unsaid};
        std::array<std::int64_t, program::max_rotary_letters> rotary{unsaid, unsaid, unsaid};
        std::array<std::int64_t, 3> axis{unsaid, unsaid, unsaid};
    };
    /// Makes goal_ of a move. Errors: NC0904.
    bool aim(const Move& to);
    bool says_linear(std::size_t i) const { return goal_.linear[i] != unsaid && goal_.linear[i] != said_.linear[i]; }
    bool says_rotary(std::size_t i) const { return goal_.rotary[i] != unsaid && goal_.rotary[i] != said_.rotary[i]; }
    bool goes() const { return says_linear(0) || says_linear(1) || says_linear(2); }
    bool turns_words() const { return says_rotary(0) || says_rotary(1) || says_rotary(2); }
    bool turns_vector() const { return goal_.axis[0] != unsaid && goal_.axis != said_.axis; }
    bool moves_at_all() const { return goes() || turns_words() || turns_vector(); }
    /// The text has now said the goal, with this move.
    void arrive(const Move& to);
    void forget_linear() { said_.linear.fill(unsaid); }
    void forget_rotary() { said_.rotary.fill(unsaid); }
    void forget_axis() { said_.axis.fill(unsaid); }
    Eigen::Vector3d said_mm() const;
    Eigen::Vector3d goal_mm() const;

    /// What F is to be for a move towards goal_.
    struct FeedWord {
        enum class Kind : std::uint8_t { none, per_minute, inverse_time } kind = Kind::none;
        double number = 0;  ///< in the text's unit
    };
    /// `turn_mm`: what a radian counts in F of blocks that only turn, where that is a length; 0: F is deg/min then;
    /// below 0: F counts for nothing there.
    static constexpr double feed_of_turns_counts_for_nothing = -1;
    FeedWord feed_word(const Move& to, bool on_arc, bool has_inverse_time, double turn_mm);

    /// Whether an arc from where the text stands to goal_ goes as that of the program does, within a few steps.
    bool goes_the_same_way(const program::Arc& read, const Move& to) const;
    /// An arc or a part of a curve from the end of `from` to that of `to` as straight moves.
    bool divide(const Move& from, const Move& to);

    const program::Program& program_;
    const machine::Machine* machine_;
    const WriteOptions& options_;
    TextWriter out_;
    Findings findings_;
    Goal goal_, said_;
    static constexpr double finer_share = 0.01;  ///< of the precision: centres of arcs and following axes
    DecimalGrid linear_grid_, rotary_grid_, vector_grid_, following_grid_;
    std::vector<double> following_mm_;  ///< where the following axes are to be: running totals
    std::int32_t line_ = 0;
    std::size_t index_ = 0;  ///< of the move in work
    Move last_;              ///< the last one that was written

  private:
    bool everything();
    bool events_before(std::size_t move);
    bool write_event(const program::Event& event);
    bool write_move(std::size_t index);
    bool write_whole(const Move& to);
    /// Makes following_mm_ of a share of the move in work. Errors: NC0904.
    bool follow(double share);
    bool holds_following();
    bool write_straight(const Move& to);
    std::optional<double> length_mm(const Move& to) const;
    std::optional<double> turn_rad(const Move& to) const;
    FeedWord as_speed_or_time(const Move& to, double time_s, bool turns_only, bool has_inverse_time, double turn_mm);

    std::vector<double> followed_mm_;  ///< where the following axes were before the move in work
    double unit_mm_ = 1;
    std::size_t event_ = 0, path_control_ = 0, curve_end_ = 0;
    bool ended_ = false;
};

std::unique_ptr<ProgramWriter> make_rs274_writer(const program::Program& program, const machine::Machine* machine,
                                                 const WriteOptions& options, const TextSink& sink);
std::unique_ptr<ProgramWriter> make_sinumerik_writer(const program::Program& program, const machine::Machine* machine,
                                                     const WriteOptions& options, const TextSink& sink);
std::unique_ptr<ProgramWriter> make_fanuc_writer(const program::Program& program, const machine::Machine* machine,
                                                 const WriteOptions& options, const TextSink& sink);
std::unique_ptr<ProgramWriter> make_heidenhain_writer(const program::Program& program, const machine::Machine* machine,
                                                      const WriteOptions& options, const TextSink& sink);
std::unique_ptr<ProgramWriter> make_apt_writer(const program::Program& program, const machine::Machine* machine,
                                               const WriteOptions& options, const TextSink& sink);

}  // namespace trunnion::nc
