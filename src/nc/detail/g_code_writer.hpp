#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "detail/arcs.hpp"
#include "detail/program_writer.hpp"

namespace trunnion::nc {

/// What the dialects of G-code write alike.
class GCodeWriter : public ProgramWriter {
  protected:
    /// In what one dialect differs from the others.
    struct Habits {
        NumberStyle numbers{};
        char comment_begin = '(', comment_end = ')';  ///< end 0: to the end of the line
        bool turns_of_helix_by_p = false;             ///< P2: one whole turn more
        double turn_mm = 0;  ///< what a radian counts in F of blocks that only turn; 0: F is deg/min
        ArcTolerance arcs = linuxcnc_arcs;
    };

    GCodeWriter(const program::Program& program, const machine::Machine* machine, const WriteOptions& options,
                const TextSink& sink, const Habits& habits)
        : ProgramWriter(program, machine, options, sink),
          habits_(habits),
          said_following_(program.following_letters.size()) {}

    bool straight(const Move& to) override;
    bool arc(const Move& to) override;
    bool action(const Action& action, const program::Event& event) override;
    bool own_word(const program::Event& event) override;
    void comment(std::string_view text) override;

    /// Words in front of the motion word: G53, G9 …
    virtual void words_before_motion(const Move&) {}
    /// Says the tool's orientation where it changes: rotary words, or by vector_words().
    virtual void orientation_words(const Move& to);
    virtual void vector_words() {}
    /// `P2`, `TURN=1`.
    virtual void turn_words(int) {}
    virtual bool takes_turns() const { return true; }
    /// A dwell in the dialect's words.
    virtual void dwell(double seconds) = 0;
    virtual bool prepare_tool(std::string_view name) = 0;
    virtual bool change_tool(std::string_view name) = 0;
    virtual std::string_view word_of(Action::Kind kind) const;

    void begin_block();
    void word(std::string_view address, const DecimalGrid& grid, std::int64_t steps);
    /// A block of one word.
    void line(std::string_view word);
    void head_comments();
    void motion_word(int code);
    void linear_words();
    void rotary_words();
    /// E where it changes, from where the text has counted it or from 0, as the program did.
    void following_words();
    bool says_following() const;
    std::int64_t following_steps(std::size_t i) const;
    /// A block in which the following axes go alone, a word of their counting (M82, M83), or G92 of theirs.
    bool following_event(const program::Event& event) override;
    bool count_following(std::string_view words);
    bool follow_alone(const program::Event& event);
    void feed_words(const Move& to, bool on_arc);
    void put_feed(const FeedWord& feed);
    void set_plane(int normal_axis);
    /// X, Y, Z that the arc turns about, with its sense as seen against it, −1: none.
    static int plane_of(const program::Arc& arc);
    /// The whole turns to say so that the reader makes the same arc; −1: it would not.
    int turns_to_say(const program::Arc& arc, const Eigen::Vector3d& normal, const Eigen::Vector3d& centre_mm,
                     const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm) const;

    Habits habits_;
    int motion_ = -1;  ///< G word in force
    int plane_ = 2;
    bool inverse_time_ = false;
    double feed_ = 0;  ///< as F said it
    /// What the text has said of a following axis, in steps, and the total at which it counts 0, in the text's unit.
    struct SaidFollowing {
        std::int64_t steps = 0;
        double origin = 0;
    };
    std::vector<SaidFollowing> said_following_;
    bool follows_incrementally_ = false;
    std::int64_t number_ = 0;
};

}  // namespace trunnion::nc
