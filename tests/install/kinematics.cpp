// One room alone: where the tip of a three-axis machine is.
#include <cstddef>
#include <cstdio>

#include <trunnion/machine/kinematics.hpp>

int main() {
    namespace machine = trunnion::machine;
    machine::Machine three_axis;
    three_axis.axis_count = 3;
    three_axis.chain = {0, 1, 2};
    for (std::size_t i = 0; i < 3; ++i) {
        three_axis.axes[i].letter = "XYZ"[i];
        three_axis.axes[i].direction = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(i));
    }
    constexpr double tool_length_mm = 50;
    const auto kinematics = machine::Kinematics::make(three_axis, {}, tool_length_mm);
    if (!kinematics) return 2;
    const auto pose = kinematics->forward({{1, 2, 60}});
    std::printf("tip %g %g %g\n", pose.tip_in_workpiece_mm.x(), pose.tip_in_workpiece_mm.y(),
                pose.tip_in_workpiece_mm.z());
    return 0;
}
