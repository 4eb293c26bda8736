#include "detail/prediction_account.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::controller {

namespace {

constexpr double full_feed = 0.9;  // of the programmed one: less is a drop
constexpr double worth_telling_s = 1e-3;

std::pair<int, int> key_of(motion::Limit limit) {
    return {static_cast<int>(limit.kind), limit.axis};
}

motion::Limit limit_of(std::pair<int, int> key) {
    return {static_cast<motion::LimitKind>(key.first), static_cast<std::int8_t>(key.second)};
}

}  // namespace

void PredictionAccount::add_to_line(std::int32_t line, double duration_s) {
    if (lines_.empty() || lines_.back().line != line) lines_.push_back({line, time_s(), 0});
    lines_.back().duration_s += duration_s;
}

void PredictionAccount::wait(std::int32_t line, bool rapid, double duration_s) {
    if (!(duration_s > 0)) return;
    add_to_line(line, duration_s);
    (rapid ? rapid_s_ : cut_s_) += duration_s;
    if (!rapid) limits_[key_of({motion::LimitKind::stop})] += duration_s;
}

void PredictionAccount::add(const MotionPiece& piece) {
    if (!(piece.duration_s > 0)) return;
    if (piece.rapid)
        end_drop();
    else
        follow_drop(piece);
    add_to_line(piece.line, piece.duration_s);
    (piece.rapid ? rapid_s_ : cut_s_) += piece.duration_s;
    path_mm_ += piece.way_mm;
    if (!piece.rapid) limits_[key_of(piece.limit)] += piece.duration_s;
}

/// Cuts off what of a piece is slower than the full feed.
void PredictionAccount::follow_drop(const MotionPiece& piece) {
    const double full = full_feed * piece.programmed_feed_mm_s;
    const double from = piece.feed_from_mm_s, to = piece.feed_to_mm_s;
    if (!(full > 0)) return end_drop();
    const double crossing = from == to ? 1 : std::clamp((full - from) / (to - from), 0.0, 1.0);
    if (from < full) {
        slow(piece, 0, to < full ? 1 : crossing);
        if (to >= full) end_drop();
    } else {
        end_drop();
        if (to < full) slow(piece, crossing, 1);
    }
}

void PredictionAccount::slow(const MotionPiece& piece, double begin, double end) {
    const double from = std::lerp(piece.feed_from_mm_s, piece.feed_to_mm_s, begin);
    const double to = std::lerp(piece.feed_from_mm_s, piece.feed_to_mm_s, end);
    const double mean = 0.5 * (piece.feed_from_mm_s + piece.feed_to_mm_s);
    const auto way = [&](double share) {
        const double part = share * (piece.feed_from_mm_s + 0.5 * share * (piece.feed_to_mm_s - piece.feed_from_mm_s));
        return mean > 0 ? part / mean * piece.way_mm : share * piece.way_mm;
    };
    if (!drop_)
        drop_ = motion::PredictedDrop{.line = piece.line,
                                      .s_from_mm = path_mm_ + way(begin),
                                      .feed_min_mm_s = INFINITY,
                                      .programmed_feed_mm_s = piece.programmed_feed_mm_s};
    if (std::min(from, to) < drop_->feed_min_mm_s) {
        drop_->feed_min_mm_s = std::min(from, to);
        drop_->line = piece.line;
        drop_->programmed_feed_mm_s = piece.programmed_feed_mm_s;
    }
    drop_->s_to_mm = path_mm_ + way(end);
    const double lost = piece.duration_s * (end - begin) - (way(end) - way(begin)) / piece.programmed_feed_mm_s;
    drop_->lost_s += lost;
    costs_[key_of(from == to ? piece.limit : from < to ? piece.limit_from : piece.limit_to)] += lost;
}

void PredictionAccount::end_drop() {
    if (drop_ && drop_->lost_s > worth_telling_s) {
        const auto most = std::ranges::max_element(costs_, {}, [](const auto& entry) { return entry.second; });
        drop_->cause = limit_of(most->first);
        drops_.push_back(*drop_);
    }
    drop_.reset();
    costs_.clear();
}

void PredictionAccount::note_load(std::size_t axis, double velocity_ratio, double acceleration_ratio,
                                  double jerk_ratio) {
    loads_[axis].velocity_ratio = std::max(loads_[axis].velocity_ratio, velocity_ratio);
    loads_[axis].acceleration_ratio = std::max(loads_[axis].acceleration_ratio, acceleration_ratio);
    loads_[axis].jerk_ratio = std::fmax(loads_[axis].jerk_ratio, jerk_ratio);
}

void PredictionAccount::finish(motion::Prediction& prediction) {
    end_drop();
    prediction.cut_time_s = cut_s_;
    prediction.rapid_time_s = rapid_s_;
    prediction.path_length_mm = path_mm_;
    prediction.feed_drops = std::move(drops_);
    prediction.lines = std::move(lines_);
    prediction.axes.clear();
    for (int a = 0; a < machine_.axis_count; ++a) {
        auto load = loads_[static_cast<std::size_t>(a)];
        load.letter = machine_.axes[static_cast<std::size_t>(a)].letter;
        for (const auto& [limit, time] : limits_)
            if (limit.second == a && cut_s_ > 0) load.limiting_share += time / cut_s_;
        prediction.axes.push_back(load);
    }
    prediction.limits.clear();
    for (const auto& [limit, time] : limits_) prediction.limits.push_back({limit_of(limit), time});
    std::ranges::stable_sort(prediction.limits, std::ranges::greater{}, &motion::LimitTime::time_s);
}

}  // namespace trunnion::controller
