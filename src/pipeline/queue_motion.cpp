#include "trunnion/pipeline/queue_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "trunnion/feed/live_planner.hpp"
#include "trunnion/smoothing/splice.hpp"

#include "detail/live_motion_steps.hpp"
#include "detail/queued_way.hpp"

namespace trunnion::pipeline {

namespace {

using feed::LivePlanner;

// A smoothing does not know what came before its first move and comes behind its last one, and its curve feels that
// for the reach of some bumps: so much of both ends is not used, in way and in moves.
constexpr double reach_mm = 22;
constexpr std::size_t reach_moves = 4;
constexpr double margin_mm = 8;       // more of the begin, so that there are places for the joint
constexpr double largest_gap = 1e-5;  // of two smoothings: beyond, they are not the same curve
constexpr std::size_t most_moves =
    500;  // that are taken up at once, and that the way is known ahead of the present place
constexpr std::size_t known_for_a_new = 4;
constexpr std::size_t between_trials = 50;  // periods; twice as many after each trial that failed
constexpr int most_doublings = 5;
constexpr double largest_override = 2;
constexpr double at_border_mm = 1e-8;  // of two moves

/// How many pieces of a leg that is open are the same when more moves come.
std::size_t known_pieces(const path::ToolPath& path) {
    if (path.blocks.size() <= reach_moves) return 0;
    const double latest_mm =
        std::min(path.length_mm() - reach_mm, path.blocks[path.blocks.size() - reach_moves].begin_mm);
    const auto next = std::upper_bound(path.pieces.begin(), path.pieces.end(), latest_mm,
                                       [](double p, const path::PathPiece& piece) { return p < piece.begin_mm; });
    return next == path.pieces.begin() ? 0 : static_cast<std::size_t>(next - path.pieces.begin()) - 1;
}

}  // namespace

class QueueMotion::State {
  public:
    State(const machine::Machine& machine, double tool_length_mm, const QueuedPose& begin, const QueueOptions& options);

    void add(const QueuedMove& move);
    void close();
    void set_override(double factor);
    void set_largest_speed(double mm_s);
    void hold();
    void resume();
    void step_through(std::optional<std::int32_t> number);
    Result<LiveMotionState> tick(bool may_plan);
    std::int32_t done_at_standstill() const;
    const LiveRow& row() const { return row_; }
    std::size_t plan() const { return plans_ + (now_.planner ? now_.planner->plans() : 0); }
    void rows_ahead(std::vector<LiveRow>& rows) const;
    void keep_plan(std::size_t lead);
    void take_back_plan(std::size_t lead);

  private:
    /// A leg and the motion along it.
    struct UnderWay {
        Leg leg;
        std::optional<LivePlanner> planner;
    };

    std::size_t not_taken_up() const { return way_.moves_behind(taken_up_); }
    bool enough_to_begin() const;
    bool enough_to_go_on() const;
    Result<bool> take_up();
    Result<void> lengthen();
    Result<void> make_legs(std::int32_t first);
    Result<bool> begin_leg();
    Result<bool> join(const Leg& anew);
    std::optional<smoothing::Splice> joint_with(const path::ToolPath& anew, const feed::LiveState& present) const;
    std::optional<path::PathPlace> end_of(const Leg& leg) const;
    void set_end();
    void end_leg();
    void pass_on_commands();
    void go_on_behind_a_step();
    LiveRow row_of(const UnderWay& under_way, const feed::LiveState& state) const;

    const machine::Machine& machine_;
    QueueOptions options_;
    QueuedWay way_;
    bool closed_ = false;
    std::int32_t taken_up_ = 0;  // moves up to this one are in now_ and next_
    std::int32_t done_ = 0;      // moves up to this one are behind
    std::int32_t newest_ = 0;    // that was added
    std::deque<Leg> next_;
    UnderWay now_;
    std::optional<UnderWay> before_;  // the leg that now_ made longer, until its plan is kept
    LiveRow row_;
    std::size_t plans_ = 0, ticks_ = 0, next_trial_ = 0;
    int failed_trials_ = 0;  // in a row
    double override_ = 1, largest_speed_mm_s_ = std::numeric_limits<double>::infinity();
    bool held_ = false;
    std::optional<std::int32_t> step_;  // the last move that may be run, to its end
};

QueueMotion::State::State(const machine::Machine& machine, double tool_length_mm, const QueuedPose& begin,
                          const QueueOptions& options)
    : machine_(machine), options_(options), way_(machine, tool_length_mm, begin, live_options(options.plan)) {
    options_.plan = live_options(options.plan);
    const auto kinematics = machine::Kinematics::make(machine, {}, tool_length_mm);
    if (!kinematics) return;
    const auto linear = kinematics->linear_for(begin.tip_mm, begin.rotary_rad);
    for (int i = 0; i < machine.linear_count(); ++i) row_.position[i] = linear[i];
    for (int i = 0; i < machine.rotary_count; ++i) row_.position[machine.linear_count() + i] = begin.rotary_rad[i];
}

void QueueMotion::State::add(const QueuedMove& move) {
    way_.add(move);
    newest_ = move.number;
    closed_ = false;
    set_end();
}

void QueueMotion::State::close() {
    closed_ = true;
    set_end();
}

void QueueMotion::State::pass_on_commands() {
    if (!now_.planner) return;
    (void)now_.planner->set_feed_override(override_);
    (void)now_.planner->set_rapid_override(std::min(override_, 1.0));
    (void)now_.planner->set_largest_speed(largest_speed_mm_s_);
    now_.planner->set_single_block(step_.has_value());
    if (held_) now_.planner->hold();
}
void QueueMotion::State::set_override(double factor) {
    override_ = std::clamp(factor, 0.0, largest_override);
    pass_on_commands();
}
void QueueMotion::State::set_largest_speed(double mm_s) {
    largest_speed_mm_s_ = mm_s;
    pass_on_commands();
}
void QueueMotion::State::hold() {
    held_ = true;
    pass_on_commands();
}
void QueueMotion::State::resume() {
    held_ = false;
    if (now_.planner) now_.planner->resume();
}
void QueueMotion::State::step_through(std::optional<std::int32_t> number) {
    step_ = number;
    pass_on_commands();
}

/// A single block's end is a standstill until the next step, and that may be allowed already.
void QueueMotion::State::go_on_behind_a_step() {
    const bool stands = now_.planner && now_.planner->periods_left() == 0;
    if (stands && !held_ && (!step_ || done_at_standstill() < *step_)) now_.planner->resume();
}

bool QueueMotion::State::enough_to_begin() const {
    return closed_ || not_taken_up() >= options_.moves_to_begin ||
           way_.way_behind_mm(taken_up_) >= options_.way_to_begin_mm;
}

/// A longer way costs as much as is known ahead: so much more the rarer.
bool QueueMotion::State::enough_to_go_on() const {
    const std::size_t known = way_.moves_behind(row_.line) - not_taken_up();
    if (known > most_moves) return false;
    return closed_ || not_taken_up() >= std::max(options_.moves_to_go_on, known / known_for_a_new);
}

/// Makes legs of what has come, where it is time to; false: nothing is to be done.
Result<bool> QueueMotion::State::take_up() {
    if (not_taken_up() == 0) return false;
    Result<void> done;
    if (!now_.planner && next_.empty()) {
        if (!enough_to_begin()) return false;
        done = make_legs(taken_up_ + 1);
    } else if (!enough_to_go_on()) {
        return false;
    } else if (!next_.empty()) {
        done = make_legs(next_.back().open ? next_.back().first : taken_up_ + 1);
    } else if (!now_.leg.open) {
        done = make_legs(taken_up_ + 1);
    } else if (ticks_ < next_trial_ || (step_ && now_.planner->periods_left() > 0)) {
        return false;
    } else {
        done = lengthen();
    }
    if (!done) return fail(done.error());
    return true;
}

/// From `first` on: a leg that begins there is made anew.
Result<void> QueueMotion::State::make_legs(std::int32_t first) {
    const std::int32_t last = way_.behind(taken_up_, most_moves);
    auto legs = way_.legs_of(first, last);
    if (!legs) return fail(legs.error());
    if (!next_.empty() && next_.back().first == first) next_.pop_back();
    for (Leg& leg : *legs) next_.push_back(std::move(leg));
    taken_up_ = last;
    return {};
}

/// The present leg with what has come behind it.
Result<void> QueueMotion::State::lengthen() {
    next_trial_ = ticks_ + (between_trials << std::min(failed_trials_++, most_doublings));
    const std::int32_t from = std::max(way_.before(row_.line, reach_moves, reach_mm + margin_mm), now_.leg.first);
    const std::int32_t last = way_.behind(taken_up_, most_moves);
    auto legs = way_.legs_of(from, last);
    if (!legs) return fail(legs.error());
    const auto behind = std::ranges::find_if(*legs, [this](const Leg& leg) { return leg.last > now_.leg.last; });
    if (behind == legs->end()) return {};
    if (behind->first <= now_.leg.last) {  // one run goes on: else the standstill between both is asked for
        const auto joined = join(*behind);
        if (!joined) return fail(joined.error());
        if (!*joined) {
            if (now_.planner->periods_left() == 0) end_leg();
            return {};
        }
        next_.assign(std::make_move_iterator(behind + 1), std::make_move_iterator(legs->end()));
    } else {
        next_.assign(std::make_move_iterator(behind), std::make_move_iterator(legs->end()));
        end_leg();
    }
    taken_up_ = last;
    failed_trials_ = 0;
    way_.drop_before(from);
    set_end();
    return {};
}

/// The place up to which more moves would not change the smoothed path, at the end of a piece: the motion goes no
/// farther as long as more may come, so that it is one along the longer path too. None where there is no such place, or
/// all have come.
std::optional<path::PathPlace> QueueMotion::State::end_of(const Leg& leg) const {
    if (!leg.open || (closed_ && not_taken_up() == 0)) return std::nullopt;
    const auto piece = known_pieces(leg.stretch->tool_path);
    if (piece == 0) return std::nullopt;
    return path::PathPlace{piece - 1, leg.stretch->tool_path.pieces[piece - 1].length_mm};
}

/// The machine stands at the end of the present leg.
void QueueMotion::State::end_leg() {
    now_.leg.open = false;
    set_end();
}

void QueueMotion::State::set_end() {
    if (now_.planner) now_.planner->set_end(end_of(now_.leg));
}

/// As late as the present leg is known, and not before the place up to which its motion is decided.
std::optional<smoothing::Splice> QueueMotion::State::joint_with(const path::ToolPath& anew,
                                                                const feed::LiveState& present) const {
    const path::ToolPath& is = now_.leg.stretch->tool_path;
    const std::int32_t line = is.blocks[present.block].line;
    const auto same = std::ranges::find(anew.blocks, line, &path::BlockSpan::line);
    if (same == anew.blocks.end()) return std::nullopt;
    smoothing::Splice out;
    out.behind_mm = is.blocks[present.block].end_mm - same->end_mm;
    out.from_piece = present.place.piece;
    out.at_piece = known_pieces(is);
    if (out.at_piece <= now_.planner->ahead(4).place.piece) return std::nullopt;
    return out;
}

Result<bool> QueueMotion::State::join(const Leg& anew) {
    const feed::LiveState present = now_.planner->ahead(0);
    const auto where = joint_with(anew.stretch->tool_path, present);
    if (!where) return false;
    const path::ToolPath& is = now_.leg.stretch->tool_path;
    auto path = smoothing::spliced(is, anew.stretch->tool_path, *where, largest_gap);
    if (!path) return false;
    std::size_t blocks_behind = 0;
    while (is.blocks[blocks_behind].end_mm <= is.pieces[where->from_piece].begin_mm) ++blocks_behind;
    auto stretch = Stretch::make(std::move(*path), machine_, {}, anew.stretch->part);
    if (!stretch) return fail(stretch.error());
    const feed::SamePath same{where->from_piece, blocks_behind, where->at_piece - where->from_piece};
    UnderWay longer{.leg = {std::move(*stretch), now_.leg.first, anew.last, anew.open}};
    auto planner =
        now_.planner->gone_on_along(*longer.leg.stretch->axis_path, options_.plan.feed, same, end_of(longer.leg));
    if (!planner) return fail(planner.error());
    if (!*planner) return false;
    longer.planner = std::move(*planner);
    before_ = std::exchange(now_, std::move(longer));
    if (now_.planner->plans() == before_->planner->plans()) before_.reset();  // the same plan
    return true;
}

Result<bool> QueueMotion::State::begin_leg() {
    if (next_.empty() || (step_ && next_.front().first > *step_)) return false;
    now_.leg = std::move(next_.front());
    next_.pop_front();
    auto planner = LivePlanner::make(*now_.leg.stretch->axis_path, options_.plan.feed, options_.plan.period_s,
                                     options_.longest_plan_s);
    if (!planner) return fail(planner.error());
    now_.planner = std::move(*planner);
    set_end();
    pass_on_commands();
    next_trial_ = ticks_;
    failed_trials_ = 0;
    return true;
}

/// Either takes moves up or plans: both take time. A stop that is asked for comes first.
Result<LiveMotionState> QueueMotion::State::tick(bool may_plan) {
    LiveMotionState out;
    out.row = row_;
    out.status = LiveMotionStatus::waiting;
    ++ticks_;
    const bool under_way = now_.planner && now_.planner->periods_left() > 0;
    const bool shall_stand = held_ || override_ == 0 || largest_speed_mm_s_ == 0;
    if (!under_way || (may_plan && !shall_stand)) {
        const auto taken = take_up();
        if (!taken) return fail(taken.error());
        may_plan = may_plan && !*taken;
    }
    if (!now_.planner) {
        const auto begun = begin_leg();
        if (!begun) return fail(begun.error());
        if (!*begun) return out;
    }
    go_on_behind_a_step();
    const bool was_under_way = now_.planner->periods_left() > 0;
    const auto state = now_.planner->tick(may_plan);
    if (!state) return fail(state.error());
    row_ = out.row = row_of(now_, *state);
    const bool moves = was_under_way || state->status == feed::LiveStatus::moving;
    out.status = moves ? LiveMotionStatus::moving : LiveMotionStatus::standing;
    if (state->status != feed::LiveStatus::finished) return out;
    done_ = now_.leg.last;
    plans_ += now_.planner->plans();
    now_.planner.reset();
    before_.reset();
    way_.drop_before(done_ + 1);
    return out;
}

std::int32_t QueueMotion::State::done_at_standstill() const {
    if (!now_.planner && !next_.empty()) return next_.front().first - 1;
    if (!now_.planner) return not_taken_up() == 0 ? newest_ : done_;
    const feed::LiveState end = now_.planner->ahead(now_.planner->periods_left());
    if (end.status == feed::LiveStatus::finished) return now_.leg.last;
    return now_.leg.stretch->tool_path.blocks[end.block].line - 1;
}

/// Where a move ends and the next one begins it is still the first.
LiveRow QueueMotion::State::row_of(const UnderWay& under_way, const feed::LiveState& state) const {
    const Stretch& stretch = *under_way.leg.stretch;
    const auto& blocks = stretch.tool_path.blocks;
    const double p_mm = stretch.tool_path.pieces[state.place.piece].begin_mm + state.place.offset_mm;
    const bool at_end = state.block > 0 && p_mm <= blocks[state.block - 1].end_mm + at_border_mm;
    return {stretch.axis_path->position(state.place), blocks[at_end ? state.block - 1 : state.block].line};
}

void QueueMotion::State::rows_ahead(std::vector<LiveRow>& rows) const {
    rows.clear();
    if (!now_.planner) return;
    const std::size_t count = now_.planner->periods_left();
    for (std::size_t k = 1; k <= count; ++k) rows.push_back(row_of(now_, now_.planner->ahead(k)));
}

void QueueMotion::State::keep_plan(std::size_t lead) {
    before_.reset();
    if (now_.planner) now_.planner->keep(lead);
}

void QueueMotion::State::take_back_plan(std::size_t lead) {
    if (before_) {
        now_ = std::move(*before_);
        before_.reset();
        next_.clear();
        taken_up_ = now_.leg.last;
        (void)now_.planner->tick(false);  // the period of the tick that changed the plan
        next_trial_ = ticks_;
        set_end();
    }
    if (!now_.planner) return;
    now_.planner->take_back(lead);
    pass_on_commands();
}

QueueMotion::QueueMotion(std::unique_ptr<State> state) : state_(std::move(state)) {}
QueueMotion::~QueueMotion() = default;
QueueMotion::QueueMotion(QueueMotion&&) noexcept = default;
QueueMotion& QueueMotion::operator=(QueueMotion&&) noexcept = default;

Result<QueueMotion> QueueMotion::make(const machine::Machine& machine, double tool_length_mm, const QueuedPose& begin,
                                      const QueueOptions& options) {
    if (!(std::isfinite(options.plan.period_s) && options.plan.period_s > 0))
        return fail({.code = "PIPE0001", .text = "the period must be more than 0"});
    return QueueMotion(std::make_unique<State>(machine, tool_length_mm, begin, options));
}

void QueueMotion::add(const QueuedMove& move) {
    state_->add(move);
}
void QueueMotion::close() {
    state_->close();
}
void QueueMotion::set_override(double factor) {
    state_->set_override(factor);
}
void QueueMotion::set_largest_speed(double mm_s) {
    state_->set_largest_speed(mm_s);
}
void QueueMotion::hold() {
    state_->hold();
}
void QueueMotion::resume() {
    state_->resume();
}
void QueueMotion::step_through(std::optional<std::int32_t> number) {
    state_->step_through(number);
}
Result<LiveMotionState> QueueMotion::tick(bool may_plan) {
    return state_->tick(may_plan);
}
std::int32_t QueueMotion::done_at_standstill() const {
    return state_->done_at_standstill();
}
LiveRow QueueMotion::begin() const {
    return state_->row();
}
std::size_t QueueMotion::plan() const {
    return state_->plan();
}
void QueueMotion::rows_ahead(std::vector<LiveRow>& rows) const {
    state_->rows_ahead(rows);
}
void QueueMotion::keep_plan(std::size_t lead) {
    state_->keep_plan(lead);
}
void QueueMotion::take_back_plan(std::size_t lead) {
    state_->take_back_plan(lead);
}

}  // namespace trunnion::pipeline
