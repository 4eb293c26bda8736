#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "trunnion/program/program.hpp"

#include "detail/findings.hpp"
#include "detail/rs274_block.hpp"

namespace trunnion::nc {

/// The surfaces that a program defines, and what it says about machining them: G320 to G324. docs/surface-g-code.md has
/// the words. It looks at letters alone; what a word does to motion is the reader's.
class SurfaceWords {
  public:
    static constexpr std::size_t most_points = 250'000;  ///< control points of all surfaces of a program together
    static constexpr std::size_t most_jobs = 10'000;     ///< machining blocks of a program
    static constexpr std::size_t most_others =
        1'000'000;  ///< surfaces that are kept out of, of all these blocks together
    static constexpr std::string_view machining_letters = "PRQIJKL";

    explicit SurfaceWords(Findings& findings) : findings_(findings) {}

    /// Between G320 or G321 and G322.
    bool is_open() const { return open_.has_value(); }

    // Each carries out one block; false: refused. `unit_mm`: of lengths in it.

    /// G320: a net of control points.
    bool open_net(const Block& block);
    /// G321: the coefficients of a polynomial.
    bool open_polynomial(const Block& block);
    /// A block behind them: a control point or coefficient, or knots.
    bool datum(const Block& block, double unit_mm);
    /// G322.
    bool close(const Block& block);
    /// G323.
    bool conditions(const Block& block, double unit_mm);
    /// G324: what its letters and the conditions say; the surface goes into the program, moved by `shift_mm`.
    bool job(const Block& block, double unit_mm, const Eigen::Vector3d& shift_mm, program::Program& program,
             program::SurfaceJob& job);
    /// At the end of the program.
    bool finish();

  private:
    struct Open {
        int number = 0;
        bool polynomial = false;
        std::size_t rows = 0, columns = 0;  ///< along u and v
        Spot spot;
        std::string file;  ///< of the spot
        program::Surface surface;
        std::size_t size() const { return rows * columns; }
    };
    struct Definition {
        program::Surface surface;
        std::int32_t index = -1;  ///< in Program::surfaces; −1: not there yet
        Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
    };

    bool open(const Block& block, Open open);
    bool only(const Block& block, std::string_view letters);
    std::optional<int> whole(const Block& block, char letter, int least, int most, std::string_view code,
                             const std::string& what);
    bool point(const Block& block, double unit_mm);
    bool weight(const Block& block);
    bool knots(const Block& block);
    bool knot(const Block& block, char letter, std::size_t most, std::vector<double>& knots);
    bool complete(const Block& block);
    bool length(const Block& block, char letter, double unit_mm, double& length_mm);
    bool freeing(const Block& block, double unit_mm);
    bool choice(const Block& block, char letter, int first, int second, bool& is_first);
    bool angle(const Block& block, char letter, double most_deg, double& angle_rad);
    bool strategy(const Block& block, program::SurfaceJob& job);
    bool place_others(const Block& block, int machined, const Eigen::Vector3d& shift_mm, program::Program& program,
                      program::SurfaceJob& job);
    bool place(const Block& block, Definition& definition, const Eigen::Vector3d& shift_mm, program::Program& program);
    bool refuse(std::string_view code, Spot spot, std::string text, std::string_view value = {},
                std::string_view hint = {}) {
        return findings_.refuse(code, spot, std::move(text), value, hint);
    }
    static Spot word(const Block& block) { return block.at(block.code_count > 0 ? block.codes[0].column : 1); }

    Findings& findings_;
    std::optional<Open> open_;
    std::map<int, Definition> definitions_;
    std::size_t points_ = 0, jobs_ = 0, others_ = 0;
    program::SurfaceJob conditions_;  ///< what G323 says
};

}  // namespace trunnion::nc
