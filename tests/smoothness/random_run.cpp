#include "random_run.hpp"

#include <Eigen/Geometry>

namespace trunnion::test {

using smoothing::test::degree;
using smoothing::test::Pose;

std::string name_of(Part part) {
    constexpr std::array<const char*, 5> names{"dense", "digits", "corners", "noise", "arcs"};
    return names[static_cast<std::size_t>(part)];
}

std::string name_of(const Laws& laws) {
    if (laws.space == path::Space::machine) return "machine";
    return laws.law == path::OrientationLaw::vector ? "vectors" : "words";
}

RandomRun::RandomRun(std::uint64_t seed, Laws laws) : random_(seed), laws_(laws) {
    place();
}

RandomRun& RandomRun::add(Part part, double length_mm) {
    switch (part) {
        case Part::dense:
            dense(length_mm, false);
            break;
        case Part::digits:
            dense(length_mm, true);
            break;
        case Part::corners:
            corners(length_mm);
            break;
        case Part::noise:
            noise(length_mm);
            break;
        case Part::arcs:
            arcs(length_mm);
            break;
    }
    return *this;
}

path::Run RandomRun::run() const {
    path::Run run = smoothing::test::run_through(poses_, laws_.law, laws_.space);
    for (const PlacedArc& placed : arcs_)
        smoothing::test::make_arc(run, placed.block, placed.arc.centre_mm, placed.arc.normal, placed.arc.angle_rad);
    return run;
}

void RandomRun::place(bool digits, double off_mm) {
    Pose pose{tip_mm_.x(), tip_mm_.y(), tip_mm_.z(), words_[0], words_[1], 0};
    for (int k = 0; k < 5; ++k) pose[k] += off_mm * random_.uniform(-1, 1) * (k < 3 ? 1 : 0.05 * degree / 0.02);
    if (digits)
        for (int k = 0; k < 5; ++k) {
            const double unit = k < 3 ? 1e-3 : 1e-3 * degree;
            pose[k] = unit * std::round(pose[k] / unit);
        }
    if (laws_.law == path::OrientationLaw::vector) {
        const double a = pose[3], c = pose[4];
        pose[3] = std::sin(a) * std::cos(c);
        pose[4] = std::sin(a) * std::sin(c);
        pose[5] = std::cos(a);
    }
    poses_.push_back(pose);
}

Eigen::Vector3d RandomRun::any_direction() {
    Eigen::Vector3d out;
    do
        for (int k = 0; k < 3; ++k) out[k] = random_.uniform(-1, 1);
    while (out.norm() < 0.1 || out.norm() > 1);
    return out.normalized();
}

/// On along the way; the tool turns on, and back where it has come far.
void RandomRun::step(double length_mm, double turn_per_mm) {
    tip_mm_ += length_mm * way_;
    for (std::size_t k = 0; k < 2; ++k) {
        if (std::abs(words_[k] - 0.5) > 0.4)
            turning_[k] = words_[k] > 0.5 ? -std::abs(turning_[k]) : std::abs(turning_[k]);
        words_[k] += turning_[k] * turn_per_mm * length_mm;
    }
}

void RandomRun::dense(double length_mm, bool digits) {
    const double curvature = random_.uniform(0, 0.1), step_mm = random_.uniform(0.05, 0.2);
    const Eigen::Vector3d about = way_.cross(any_direction()).normalized();
    for (auto& rate : turning_) rate = random_.uniform(-1, 1);
    for (double way = 0; way < length_mm; way += step_mm) {
        way_ = (way_ + curvature * step_mm * about.cross(way_)).normalized();
        step(step_mm, 0.01);
        place(digits);
    }
}

void RandomRun::corners(double length_mm) {
    for (double way = 0; way < length_mm;) {
        const double block_mm = random_.uniform(1, 20);
        const Eigen::Vector3d aside = any_direction();
        way_ = (way_ + random_.uniform(0, 1) * aside).normalized();
        for (auto& rate : turning_) rate = random_.uniform(-1, 1);
        step(block_mm, 0.02);
        place();
        way += block_mm;
    }
}

void RandomRun::noise(double length_mm) {
    for (double way = 0; way < length_mm;) {
        const double block_mm = random_.uniform(0.2, 2);
        step(block_mm, 0.01);
        place(false, 0.02);
        way += block_mm;
    }
}

void RandomRun::arcs(double length_mm) {
    for (auto& rate : turning_) rate = random_.uniform(-1, 1);
    for (double way = 0; way < length_mm;) {
        const Eigen::Vector3d normal = way_.cross(any_direction()).normalized();
        const double radius = random_.uniform(0.5, 20), angle = random_.uniform(0.3, 3);
        const Eigen::Vector3d start = tip_mm_, arm = radius * way_.cross(normal);
        const Eigen::AngleAxisd turn(angle, normal);
        const double rise = random_.uniform(0, 0.1) * radius * angle;
        if (start.isApprox(Eigen::Vector3d(poses_.back().data()), 1e-9)) {
            for (std::size_t k = 0; k < 2; ++k) words_[k] += 0.01 * turning_[k];
            tip_mm_ = start - arm + turn * arm + rise * normal;
            arcs_.push_back({poses_.size() - 1, {start - arm, normal, angle}});
            place();
            way_ = turn * way_;
            way += radius * angle;
        }
        const double straight_mm = random_.uniform(0.5, 5);
        step(straight_mm, 0.01);
        place();
        way += straight_mm;
    }
}

}  // namespace trunnion::test
