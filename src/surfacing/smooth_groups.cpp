#include <algorithm>
#include <numeric>
#include <utility>

#include "detail/joints.hpp"

namespace trunnion::surfacing::detail {

namespace {

constexpr double vertex_mm = 0.1;  ///< joints that end so near to each other end at one point

double length_mm(const SmoothJoint& joint) {
    const auto& points = joint.on_first.points;
    double sum = 0;
    for (std::size_t k = 1; k < points.size(); ++k) sum += (points[k].at - points[k - 1].at).norm();
    return sum;
}

/// Which joints are used: a tree of faces, and what closes round a common end of joints.
class Joining {
  public:
    Joining(std::size_t faces, std::vector<SmoothJoint> joints)
        : joints_(std::move(joints)), used_(joints_.size(), false), group_(faces) {
        std::iota(group_.begin(), group_.end(), std::size_t{0});
        std::ranges::stable_sort(joints_, std::ranges::greater{}, length_mm);
        for (std::size_t k = 0; k < joints_.size(); ++k) {
            const std::size_t a = group_of(joints_[k].first), b = group_of(joints_[k].second);
            if (a == b) continue;
            group_[std::max(a, b)] = std::min(a, b);
            used_[k] = true;
        }
        for (bool more = true; more;) {
            more = false;
            for (std::size_t k = 0; k < joints_.size(); ++k)
                if (!used_[k] && closes_round_a_point(k)) used_[k] = more = true;
        }
    }

    std::vector<SmoothGroup> groups() {
        std::vector<SmoothGroup> out;
        std::vector<std::size_t> place(group_.size()), number(group_.size());
        for (std::size_t k = 0; k < group_.size(); ++k) {
            const std::size_t first = group_of(k);
            if (first == k) number[k] = out.size(), out.emplace_back();
            SmoothGroup& group = out[number[first]];
            place[k] = group.faces.size();
            group.faces.push_back(k);
        }
        for (std::size_t k = 0; k < joints_.size(); ++k) {
            if (!used_[k]) continue;
            SmoothJoint joint = std::move(joints_[k]);
            SmoothGroup& group = out[number[group_of(joint.first)]];
            joint.first = place[joint.first];
            joint.second = place[joint.second];
            group.joints.push_back(std::move(joint));
        }
        return out;
    }

  private:
    std::size_t group_of(std::size_t face) const {
        while (group_[face] != face) face = group_[face];
        return face;
    }

    bool ends_at(const SmoothJoint& joint, const Eigen::Vector3d& point) const {
        const Stretch& on = joint.on_first;
        return !on.closed &&
               ((on.points.front().at - point).norm() < vertex_mm || (on.points.back().at - point).norm() < vertex_mm);
    }

    bool closes_round_a_point(std::size_t number) const {
        const Stretch& on = joints_[number].on_first;
        return !on.closed && (closes_round(number, on.points.front().at) || closes_round(number, on.points.back().at));
    }

    /// Whether all faces at a point are joined round it once this joint is used.
    bool closes_round(std::size_t number, const Eigen::Vector3d& point) const {
        std::vector<int> ends(group_.size(), 0);
        for (std::size_t k = 0; k < joints_.size(); ++k) {
            if ((!used_[k] && k != number) || !ends_at(joints_[k], point)) continue;
            ++ends[joints_[k].first];
            ++ends[joints_[k].second];
        }
        return std::ranges::all_of(ends, [](int count) { return count == 0 || count == 2; });
    }

    std::vector<SmoothJoint> joints_;
    std::vector<bool> used_;
    std::vector<std::size_t> group_;
};

}  // namespace

std::vector<SmoothGroup> smooth_groups(std::span<const Face> faces) {
    return Joining(faces.size(), smooth_joints(faces)).groups();
}

}  // namespace trunnion::surfacing::detail
