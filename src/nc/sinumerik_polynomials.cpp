#include <algorithm>

#include "detail/sinumerik_reader.hpp"

namespace trunnion::nc::sinumerik {

using Eigen::Vector3d;
using program::Curve;
using program::Move;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr std::size_t most_values = 5;  ///< of PO: the end, then the coefficients of p² … p⁵
constexpr std::string_view second_names[] = {"XH", "YH", "ZH"};

/// Whose polynomial it is; empty: the denominator.
std::string_view polynomial_axis(const Word& word) {
    return word.name == "PO" ? std::string_view(word.index) : word.name;
}

/// The linear coefficient with which a polynomial is `end` at p = `length`, from its other coefficients.
double linear_coefficient(const std::vector<double>& coefficients, double end, double length) {
    double others = coefficients[0], power = length;
    for (std::size_t k = 2; k < coefficients.size(); ++k) others += coefficients[k] * (power *= length);
    return (end - others) / length;
}

/// Of a polynomial in p from 0 to `length`, raised to a degree.
std::vector<double> ordinates(std::vector<double> coefficients, double length, std::size_t degree) {
    double power = 1;
    for (double& coefficient : coefficients) {
        coefficient *= power;
        power *= length;
    }
    coefficients.resize(degree + 1);
    return bernstein_ordinates(coefficients);
}

}  // namespace

/// PO[X]=(end,a2,a3…), X=PO(end,a2,a3…), PO[]=(end,b2…): the end counts as the word X does.
bool SinumerikReader::polynomial_word(const Word& word) {
    const std::string_view axis = polynomial_axis(word);
    const bool numbers = std::ranges::all_of(word.arguments, [](const Argument& a) {
        return a.kind == Argument::Kind::number || a.kind == Argument::Kind::empty;
    });
    const bool good = !word.arguments.empty() && word.arguments.size() <= most_values && numbers &&
                      word.arguments.front().kind == Argument::Kind::number;
    if (!good) return refuse("NC0634", word, "a polynomial is its end and up to four coefficients, of p² to p⁵");
    polynomials_.push_back(&word);
    if (axis.empty()) return true;
    Word end = word;
    end.name = axis;
    end.index.clear();
    end.is_list = false;
    end.has_value = true;
    end.value = word.arguments.front().number;
    if (!numerator_of(axis))
        return refuse("NC0634", word, "no polynomial for this word", "X Y Z, XH YH ZH, rotary axes");
    return take(end);
}

bool SinumerikReader::go_along_polynomial(const Vector3d& to) {
    said_.use(Address::parameter_length);
    PolynomialBlock block;
    block.length = said_.get(Address::parameter_length, 1);
    if (!(block.length > 0) || std::isinf(block.length))
        return refuse("NC0634", spot(Address::parameter_length),
                      "the length of a polynomial's parameter must be positive");
    if (polynomials_.empty()) return go(to, {});
    const bool left_out = rapid_left_out_ || (whole_pose_needed_ && counted_in_.space == Space::workpiece);
    if (program_.moves.empty() || position_mm_.hasNaN() || programmed_mm_.hasNaN() || to.hasNaN() || left_out)
        return refuse("NC0629", spot_of_motion(), "a curve from a place that is not known", {},
                      "say X, Y and Z in a straight move before it");
    if (modal_cycle_) return refuse("NC0628", spot_of_motion(), "a curve under MCALL");
    Curve curve;
    if (!coefficients(to, block) || !curve_of(block, curve)) return false;
    Way way{.curved = true};
    way.curve = std::move(curve);
    return go(to, way);
}

/// Of all axes: those without PO go straight to their ends.
bool SinumerikReader::coefficients(const Vector3d& to, PolynomialBlock& block) {
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        block.numerators[i] = {programmed_mm_[axis], (to[axis] - programmed_mm_[axis]) / block.length};
    }
    for (std::size_t i = 0; i < rotary_rad_.size(); ++i)
        block.numerators[PolynomialBlock::rotary + i] = {rotary_from_rad_[i],
                                                         (rotary_rad_[i] - rotary_from_rad_[i]) / block.length};
    if (modes_.second_curve && !second_mm_.hasNaN() && !second_coefficients(block)) return false;
    // The denominator first: a numerator ends at the end times the denominator's.
    for (const bool denominators : {true, false})
        for (const Word* const word : polynomials_)
            if (polynomial_axis(*word).empty() == denominators &&
                !(denominators ? denominator(*word, block) : keep_coefficients(*word, block)))
                return false;
    if (block.denominator.size() == 1) return true;
    if (!block.numerators[PolynomialBlock::second].empty())
        return refuse("NC0635", spot_of_motion(), "only X, Y and Z have a denominator, a second curve has none");
    for (std::size_t i = 0; i < 3; ++i) {  // an axis that does not move is a multiple of the denominator
        const double stays = programmed_mm_[static_cast<Eigen::Index>(i)];
        const bool by_polynomial = block.numerators[i].size() > 2;
        if (by_polynomial) continue;
        if (to[static_cast<Eigen::Index>(i)] != stays)
            return refuse("NC0635", spot_of_motion(), "an axis without PO beside a denominator", {},
                          "PO with the end alone where its numerator is linear");
        block.numerators[i] = block.denominator;
        for (double& coefficient : block.numerators[i]) coefficient *= stays;
    }
    return true;
}

/// The second curve from where it was before the block, or as far from the tip as it ends.
bool SinumerikReader::second_coefficients(PolynomialBlock& block) {
    const Vector3d end = frame_.inward(second_mm_);
    Vector3d start = frame_.inward(second_from_mm_);
    if (start.hasNaN()) {
        const Move& last = program_.moves.back();
        if (last.law != OrientationLaw::vector)
            return refuse("NC0629", spot_of_motion(), "a second curve from a tool axis that is not known as a vector",
                          {}, "XH YH ZH, or A3 B3 C3, in a straight move before it");
        Vector3d tip;
        for (Eigen::Index i = 0; i < 3; ++i) tip[i] = block.numerators[static_cast<std::size_t>(i)][0];
        const Vector3d end_tip =
            tip + Vector3d(block.numerators[0][1], block.numerators[1][1], block.numerators[2][1]) * block.length;
        start = tip + frame_.direction_inward(last.axis).normalized() * (end - end_tip).norm();
        findings_.count("NC0662", Severity::note, spot_of_motion(), "ORICURVE",
                        "the second curve starts as far from the tip as its first point: XH YH ZH were not said before",
                        "G1 X… Y… Z… XH=… YH=… ZH=… under ORICURVE before the curve");
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        block.numerators[PolynomialBlock::second + i] = {start[axis], (end[axis] - start[axis]) / block.length};
    }
    return true;
}

/// Which of a block's numerators belongs to an axis.
std::optional<std::size_t> SinumerikReader::numerator_of(std::string_view axis) const {
    const auto* const second = std::ranges::find(second_names, axis);
    if (second != std::end(second_names))
        return PolynomialBlock::second + static_cast<std::size_t>(second - std::begin(second_names));
    if (axis.size() != 1 || !is_letter(axis.front())) return {};
    if (axis >= "X") return static_cast<std::size_t>(axis.front() - 'X');
    const auto letter = static_cast<std::size_t>(axis.front() - 'A');
    if (control_.kind(letter) != Control::Letter::rotary) return {};
    return PolynomialBlock::rotary + control_.axis(letter);
}

/// Of one axis, from its PO.
bool SinumerikReader::keep_coefficients(const Word& word, PolynomialBlock& block) {
    const std::size_t axis = *numerator_of(polynomial_axis(word));
    const double unit = axis < PolynomialBlock::rotary ? modes_.unit_mm : degree;
    const bool divided = block.denominator.size() > 1;
    if (divided && axis >= 3)
        return refuse("NC0635", word, "only X, Y and Z have a denominator", "the other axes in a block of their own");
    std::vector<double>& numerator = block.numerators[axis];
    if (std::isnan(numerator[0])) return refuse("NC0629", word, "a polynomial from a position that is not known");
    double end = numerator[0] + numerator[1] * block.length;
    numerator.resize(std::max<std::size_t>(3, word.arguments.size() + 1));
    for (std::size_t k = 1; k < word.arguments.size(); ++k) numerator[k + 1] = word.arguments[k].number * unit;
    if (divided) {
        double at_end = 0;
        for (std::size_t k = block.denominator.size(); k-- > 0;) at_end = at_end * block.length + block.denominator[k];
        end *= at_end;
    }
    numerator[1] = linear_coefficient(numerator, end, block.length);
    block.degree = std::max(block.degree, numerator.size() - 1);
    return true;
}

/// PO[]: 1 at the start.
bool SinumerikReader::denominator(const Word& word, PolynomialBlock& block) {
    if (block.denominator.size() > 1) return refuse("NC0607", word, "two denominators in a block");
    block.denominator.resize(std::max<std::size_t>(3, word.arguments.size() + 1));
    for (std::size_t k = 1; k < word.arguments.size(); ++k) block.denominator[k + 1] = word.arguments[k].number;
    block.denominator[1] = linear_coefficient(block.denominator, word.arguments.front().number, block.length);
    block.degree = std::max(block.degree, block.denominator.size() - 1);
    return true;
}

/// In the work offset's frame, over [0, PL].
bool SinumerikReader::curve_of(const PolynomialBlock& block, Curve& curve) {
    constexpr std::size_t second = PolynomialBlock::second, rotary = PolynomialBlock::rotary;
    const std::size_t points = block.degree + 1;
    std::array<std::vector<double>, PolynomialBlock::axes> ordinate;
    for (std::size_t i = 0; i < ordinate.size(); ++i)
        if (!block.numerators[i].empty()) ordinate[i] = ordinates(block.numerators[i], block.length, block.degree);
    const bool divided = block.denominator.size() > 1;
    const bool turns = std::any_of(block.numerators.begin() + rotary, block.numerators.end(),
                                   [](const auto& numerator) { return numerator.size() > 2; });
    curve.degree = static_cast<int>(block.degree);
    curve.knots = clamped_knots(curve.degree, std::array{block.length});
    if (divided) curve.weights = ordinates(block.denominator, block.length, block.degree);
    const auto positive = [](double weight) { return weight > 0 && std::isfinite(weight); };
    if (!std::ranges::all_of(curve.weights, positive))
        return refuse("NC0635", spot_of_motion(), "a denominator that is not well above 0 along the whole block", {},
                      "cut the curve in shorter blocks");
    for (std::size_t i = 0; i < points; ++i) {
        const double weight = divided ? curve.weights[i] : 1;
        const Vector3d tip = Vector3d(ordinate[0][i], ordinate[1][i], ordinate[2][i]) / weight;
        curve.position_mm.push_back(*frame_.outward(tip));
        if (!curve.position_mm.back().allFinite()) return refuse("NC0201", spot_of_motion(), "the curve is not finite");
        if (!ordinate[second].empty()) {
            const Vector3d top(ordinate[second][i], ordinate[second + 1][i], ordinate[second + 2][i]);
            curve.axis.push_back(*frame_.outward(top) - curve.position_mm.back());
        }
        if (!turns) continue;
        curve.rotary_rad.push_back({ordinate[rotary][i], ordinate[rotary + 1][i], ordinate[rotary + 2][i]});
        if (has_free_rotary(curve.rotary_rad.back()))
            return refuse("NC0629", spot_of_motion(), "a curve with rotary words from angles that are not known", {},
                          "say all rotary axes in a straight move before it");
        for (double& word : curve.rotary_rad.back()) {
            if (std::isnan(word)) word = 0;  // the machine has no such axis
            if (std::isinf(word)) return refuse("NC0201", spot_of_motion(), "the curve is not finite");
        }
    }
    if (turns && law_ != OrientationLaw::rotary)
        return refuse("NC0617", spot_of_motion(), "polynomials of rotary axes beside tool vectors");
    if (std::ranges::all_of(curve.position_mm, [&](const Vector3d& p) { return p == curve.position_mm.front(); }))
        return refuse("NC0637", spot_of_motion(), "a curve along which the tip does not move", {},
                      "turn the tool with G1");
    return has_direction_everywhere(curve) ||
           refuse("NC0637", spot_of_motion(), "the tool turns so far along a curve that its direction may vanish", {},
                  "cut the curve in shorter blocks");
}

}  // namespace trunnion::nc::sinumerik
