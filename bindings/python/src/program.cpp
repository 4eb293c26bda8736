#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/nc/read.hpp"
#include "trunnion/nc/write.hpp"
#include "trunnion/pipeline/convert.hpp"
#include "trunnion/pipeline/expand_surfaces.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "program_words.hpp"
#include "series.hpp"

namespace trunnion::python {

using program::Move;
using program::Program;
using SharedProgram = std::shared_ptr<Program>;

namespace {

/// Three numbers a row.
py::dtype triple() {
    return py::dtype::from_args(py::make_tuple(py::dtype::of<double>(), py::make_tuple(3)));
}

/// Where a member of a move lies.
template <class Member>
py::ssize_t offset(const Move& move, const Member& member) {
    return reinterpret_cast<const char*>(&member) - reinterpret_cast<const char*>(&move);
}

/// Made of types, not of their names as text: numpy parses those by `ast`, which before Python 3.11.5 fails in two
/// threads at once.
py::dtype move_type() {
    py::list names, formats, offsets;
    const Move move;
    const auto add = [&](const char* name, const py::dtype& format, const auto& member) {
        names.append(name);
        formats.append(format);
        offsets.append(offset(move, member));
    };
    add("position_mm", triple(), move.position_mm);
    add("axis", triple(), move.axis);
    add("rotary_rad", triple(), move.rotary_rad);
    add("arc", py::dtype::of<std::int32_t>(), move.arc);
    add("curve_part", py::dtype::of<std::int32_t>(), move.curve_part);
    add("feed_rule", py::dtype::of<std::uint8_t>(), move.feed.rule);
    add("feed", py::dtype::of<double>(), move.feed.value);
    add("kind", py::dtype::of<std::uint8_t>(), move.kind);
    add("space", py::dtype::of<std::uint8_t>(), move.space);
    add("law", py::dtype::of<std::uint8_t>(), move.law);
    add("exact_stop", py::dtype::of<bool>(), move.exact_stop);
    add("tool", py::dtype::of<std::uint16_t>(), move.tool);
    add("offset", py::dtype::of<std::uint16_t>(), move.offset);
    add("line", py::dtype::of<std::int32_t>(), move.line);
    return py::dtype(names, formats, offsets, sizeof(Move));
}

py::array moves(py::handle self, const py::dtype& type) {
    const auto& all = self.cast<const Program&>().moves;
    return view_of(all.data(), type, {static_cast<py::ssize_t>(all.size())}, {sizeof(Move)}, self);
}

/// A column of three numbers over all moves.
py::array column(py::handle self, const Eigen::Vector3d Move::* member) {
    const auto& all = self.cast<const Program&>().moves;
    return view_of(all.empty() ? nullptr : (all.front().*member).data(), py::dtype::of<double>(),
                   {static_cast<py::ssize_t>(all.size()), 3}, {sizeof(Move), sizeof(double)}, self);
}

py::array lines(py::handle self) {
    const auto& all = self.cast<const Program&>().moves;
    return view_of(all.empty() ? nullptr : &all.front().line, py::dtype::of<std::int32_t>(),
                   {static_cast<py::ssize_t>(all.size())}, {sizeof(Move)}, self);
}

py::list events(const Program& program) {
    py::list out;
    for (const program::Event& event : program.events) {
        py::dict row;
        row["kind"] = name_of(event.kind, event_kinds);
        row["word"] = event.word;
        row["stops_motion"] = event.stops_motion;
        row["dwell_s"] = event.dwell_s;
        row["before_move"] = event.before_move;
        row["line"] = event.line;
        out.append(row);
    }
    return out;
}

/// Null where none is given.
const machine::Machine* machine_in(Keywords& keywords) {
    const py::handle given = keywords.take("machine");
    return given ? &object_of<machine::Machine>(given, "machine") : nullptr;
}

SharedProgram read_program(py::handle source, bool from_text, const py::kwargs& given) {
    Keywords keywords(given, "read_program");
    nc::ReadOptions options;
    options.machine = machine_in(keywords);
    if (const py::handle word = keywords.take("dialect")) options.dialect = word_of(word, "dialect", dialects);
    keywords.word("units", options.units, length_units);
    keywords.flag("feed_given_elsewhere", options.feed_given_elsewhere);
    std::string name = "program";
    if (from_text) keywords.text("name", name);
    keywords.finish();
    const std::string text = from_text ? text_of(source, "text") : path_of(source, "path");
    const py::gil_scoped_release released;
    return std::make_shared<Program>(
        value_of(from_text ? nc::read_program(text, name, options) : nc::read_program_file(text, options)));
}

/// One number for all, or one for each pose.
std::vector<double> for_each_pose(py::handle object, const char* name, std::size_t poses) {
    const Array given = numbers_of(object, name);
    if (given.ndim() == 0) return std::vector<double>(poses, *given.data());
    if (given.ndim() == 1 && static_cast<std::size_t>(given.size()) == poses) return list_of(given, name);
    refuse(
        {.code = "PY0001", .text = fmt::format("{}: one number, or one for each of the {} poses wanted", name, poses)});
}

std::vector<bool> mask_of(py::handle object, const char* name, std::size_t poses) {
    if (!object) return std::vector<bool>(poses, false);
    const py::array given = py::array::ensure(object);
    if (!given || given.dtype().kind() != 'b' || given.ndim() != 1 || static_cast<std::size_t>(given.size()) != poses)
        refuse({.code = "PY0001",
                .text = fmt::format("{}: an array of bool, one for each of the {} poses, wanted", name, poses)});
    const auto mask = py::array_t<bool>::ensure(given);
    return std::vector<bool>(mask.data(), mask.data() + mask.size());
}

/// Rotary words instead of tool axes.
struct RotaryWords {
    std::vector<char> letters;
    Rows degrees;
};

RotaryWords words_of_poses(py::handle letters, py::handle degrees, const Rows& tips) {
    const std::string text = text_of(letters, "rotary_letters");
    RotaryWords out{{text.begin(), text.end()}, {}};
    const bool known = std::ranges::all_of(text, [](char c) { return c >= 'A' && c <= 'Z'; });
    if (text.empty() || text.size() > program::max_rotary_letters || !known)
        refuse({.code = "PY0003", .text = "rotary_letters: one to three capital letters wanted", .value = text});
    if (!degrees) refuse({.code = "PY0001", .text = "rotary_deg: wanted together with rotary_letters"});
    out.degrees = rows_like(degrees, "rotary_deg", static_cast<int>(text.size()), tips, "tips");
    return out;
}

void set_orientation(Move& move, py::ssize_t i, const std::optional<Rows>& axes,
                     const std::optional<RotaryWords>& words) {
    if (axes) move.axis = axes->vector(i);
    if (!words) return;
    move.law = program::OrientationLaw::rotary;
    for (int r = 0; r < words->degrees.width; ++r)
        move.rotary_rad[static_cast<std::size_t>(r)] = words->degrees.row(i)[r] * degree;
}

/// What a program of poses is made of.
struct PoseArguments {
    Rows tips;
    std::optional<Rows> axes;          ///< neither these nor words: along Z
    std::optional<RotaryWords> words;  ///< in place of axes
    std::vector<double> feeds_mm_min;
    std::vector<bool> rapid, stops;
    std::string name = "poses";
};

PoseArguments take_poses(py::handle tips, py::handle axes, const py::kwargs& given) {
    PoseArguments out{.tips = rows_of(tips, "tips", 3)};
    if (out.tips.leading.size() != 1 || out.tips.count == 0)
        refuse({.code = "PY0001", .text = "tips: shape (n, 3) with at least one pose wanted"});
    const auto poses = static_cast<std::size_t>(out.tips.count);
    Keywords keywords(given, "program_from_poses");
    const py::handle feed = keywords.take("feed_mm_min"), letters = keywords.take("rotary_letters"),
                     degrees = keywords.take("rotary_deg");
    if (!feed) refuse({.code = "PY0001", .text = "feed_mm_min: wanted", .hint = "mm/min of the tip"});
    out.feeds_mm_min = for_each_pose(feed, "feed_mm_min", poses);
    out.rapid = mask_of(keywords.take("rapid"), "rapid", poses);
    out.stops = mask_of(keywords.take("exact_stop"), "exact_stop", poses);
    keywords.text("name", out.name);
    keywords.finish();
    if (letters && !axes.is_none()) refuse({.code = "PY0003", .text = "axes: not together with rotary_letters"});
    if (degrees && !letters) refuse({.code = "PY0001", .text = "rotary_letters: wanted together with rotary_deg"});
    if (letters) out.words = words_of_poses(letters, degrees, out.tips);
    if (!axes.is_none()) out.axes = directions_like(axes, "axes", out.tips, "tips");
    return out;
}

program::Feed feed_of(const PoseArguments& poses, std::size_t i) {
    const double feed = poses.feeds_mm_min[i];
    if (feed > 0) return {program::FeedRule::tip_speed, feed / 60};
    refuse({.code = "PY0003",
            .text = fmt::format("feed_mm_min: not above 0 at pose {}", i),
            .value = fmt::format("{}", feed)});
}

SharedProgram program_from_poses(py::handle tips, py::handle axes, const py::kwargs& given) {
    const PoseArguments poses = take_poses(tips, axes, given);
    auto out = std::make_shared<Program>();
    out->name = poses.name;
    if (poses.words) out->rotary_letters = poses.words->letters;
    out->moves.resize(static_cast<std::size_t>(poses.tips.count));
    for (std::size_t i = 0; i < out->moves.size(); ++i) {
        Move& move = out->moves[i];
        const auto row = static_cast<py::ssize_t>(i);
        move.position_mm = poses.tips.vector(row);
        set_orientation(move, row, poses.axes, poses.words);
        move.exact_stop = poses.stops[i];
        move.line = static_cast<std::int32_t>(i) + 1;
        if (poses.rapid[i] || i == 0)
            move.kind = program::MoveKind::rapid;
        else
            move.feed = feed_of(poses, i);
    }
    return out;
}

nc::WriteOptions write_options(Keywords& keywords, const Program& program) {
    nc::WriteOptions out;
    out.dialect = nc::dialect_named(program.dialect).value_or(nc::Dialect::rs274);
    keywords.word("dialect", out.dialect, dialects);
    keywords.word("units", out.units, length_units);
    keywords.word("curves", out.curves, curve_forms);
    keywords.number("precision_mm", out.precision_mm);
    double angle_deg = out.precision_deg;
    keywords.number("precision_deg", angle_deg);
    if (out.precision_mm <= 0 || angle_deg <= 0)
        refuse({.code = "PY0003", .text = "precision_mm, precision_deg: above 0 wanted"});
    out.vector_precision = 0.5 * degree * angle_deg;  // of three components together
    out.precision_deg = angle_deg;
    keywords.flag("block_numbers", out.block_numbers);
    keywords.flag("inverse_time", out.inverse_time);
    if (const py::handle head = keywords.take("head"))
        for (const py::handle line : items_of(head, "head", "lines of text")) out.head.push_back(text_of(line, "head"));
    return out;
}

py::list write(const Program& self, py::handle path, const py::kwargs& given) {
    Keywords keywords(given, "write");
    const auto options = write_options(keywords, self);
    const machine::Machine* machine = machine_in(keywords);
    keywords.finish();
    const std::string file = path_of(path, "path");
    const auto written = [&] {
        const py::gil_scoped_release released;
        return pipeline::write_program_file(file, self, machine, options);
    }();
    return py::cast(value_of(written).diagnostics);
}

std::string text(const Program& self, const py::kwargs& given) {
    Keywords keywords(given, "text");
    const auto options = write_options(keywords, self);
    const machine::Machine* machine = machine_in(keywords);
    keywords.finish();
    const py::gil_scoped_release released;
    return value_of(nc::write_text(self, machine, options));
}

SharedProgram translate(const Program& self, const machine::Machine& machine, py::handle setup, py::handle law,
                        py::handle precision) {
    const auto wanted = word_of(law, "law", laws);
    const double precision_rad = positive_of(precision, "precision_deg") * degree;
    const machine::Setup& placed = setup_of(setup);
    const py::gil_scoped_release released;
    return std::make_shared<Program>(value_of(pipeline::translate(self, machine, placed, wanted, precision_rad)));
}

SharedProgram expand_surfaces(const Program& self, py::handle setup) {
    const machine::Setup& placed = setup_of(setup);
    const py::gil_scoped_release released;
    return std::make_shared<Program>(value_of(pipeline::expand_surfaces(self, placed)));
}

constexpr const char* program_doc =
    R"(A part program, modal words resolved; made by `read_program()` and its like. Immutable.

`moves[0]` is where motion starts; every later move goes from the end of the one before. Arrays are read-only views of the
program's own memory and keep it alive.)";

constexpr const char* moves_doc = R"(ndarray, shape (n,), structured: a view, no copy.

`position_mm` (3) end of the move, `axis` (3) unit tool axis under law 0, `rotary_rad` (3) literal rotary words under law 1,
`feed` in mm/s, rad/s or s as `feed_rule` says (0 none, 1 speed of the tip, 2 rate of the rotary words, 3 time of the block),
`kind` (0 rapid, 1 feed), `space` (0 workpiece, 1 machine, 2 axes as counted with TCP off), `law` (0 vector, 1 rotary),
`exact_stop`, `tool`, `offset`, `arc`, `curve_part` (-1: none), `line`. NaN: the coordinate stays what it was.)";

constexpr const char* write_doc = R"(write($self, path, **options)
--

Writes the program as a file, which appears complete or not at all; a name that ends in `.gz` is compressed.

Parameters
----------
path : str or os.PathLike
dialect : {'apt', 'rs274', 'sinumerik', 'heidenhain', 'fanuc'}, optional
    Default: its own, else rs274.
machine : Machine, optional
    Its words for TCP; without it LinuxCNC's.
units : {'mm', 'inch'}
curves : {'own', 'bspline', 'poly', 'nurbs', 'points'}
    As what curves are written; 'own': what the dialect has and they fit into.
precision_mm, precision_deg : float
    Largest errors of what is written: 5e-5 and 5e-7.
block_numbers, inverse_time : bool
head : iterable of str
    Comment lines at the beginning.

Returns
-------
list of Diagnostic
    What the dialect says otherwise.

Raises
------
Error
    NC0901 to NC0909, NC0920; FILE0201, FILE0202; PIPE0011 the program's own source.)";

constexpr const char* text_doc = R"(text($self, **options)
--

The program as one string; options and errors as write().)";

constexpr const char* translate_doc = R"(translate($self, machine, setup=None, law='vector', precision_deg=0.001)
--

The same tool path with every move with TCP on under one orientation law.

Parameters
----------
machine : Machine
setup : Setup, optional
law : {'vector', 'rotary'}
precision_deg : float
    How far the tool axis may lie off; moves are divided for it.

Returns
-------
Program

Raises
------
Error
    PIPE0012, PIPE0014, and those of choosing branch and winding (PATH).)";

constexpr const char* expand_surfaces_doc = R"(expand_surfaces($self, setup=None)
--

The program with the passes of the surfaces that it defines in their places; `plan()` does it by itself.

Parameters
----------
setup : Setup, optional
    Has the tools.

Returns
-------
Program

Raises
------
Error
    PIPE0120 a tool that the setup has not; codes SURF02….)";

void bind_program_class(py::module_& module) {
    py::class_<Program, SharedProgram>(module, "Program", program_doc)
        .def_readonly("name", &Program::name, "str: as the program says, or the file's stem.")
        .def_readonly("source", &Program::source, "str: the file.")
        .def_readonly("dialect", &Program::dialect,
                      "str: `apt`, `rs274`, `sinumerik`, `heidenhain`, `fanuc`; empty: none.")
        .def_property_readonly(
            "rotary_letters",
            [](const Program& p) { return std::string(p.rotary_letters.begin(), p.rotary_letters.end()); },
            "str: order of `rotary_rad`.")
        .def_readonly("tools", &Program::tools, "list of str: names that moves call by index; the first: none.")
        .def_readonly("offsets", &Program::offsets, "list of str: work offsets by index; the first: the workpiece.")
        .def_readonly("diagnostics", &Program::diagnostics, "list of Diagnostic: what reading noticed.")
        .def("__len__", [](const Program& p) { return p.moves.size(); })
        .def_property_readonly(
            "moves", [type = move_type()](py::object self) { return moves(self, type); }, moves_doc)
        .def_property_readonly(
            "positions_mm", [](py::object self) { return column(self, &Move::position_mm); },
            "ndarray, shape (n, 3): ends of the moves, mm; a view, no copy.")
        .def_property_readonly(
            "axes", [](py::object self) { return column(self, &Move::axis); },
            "ndarray, shape (n, 3): unit tool axes of moves under law vector; a view, no copy.")
        .def_property_readonly(
            "lines", [](py::object self) { return lines(self); },
            "ndarray of int32, shape (n,): lines of the source; a view, no copy.")
        .def_property_readonly("events", &events, R"(list of dict: what happens besides motion, in order.

`kind`, `word` as written, `stops_motion`, `dwell_s`, `before_move` (it falls where that move begins), `line`.)")
        .def_property_readonly(
            "surface_jobs", [](const Program& p) { return p.surface_jobs.size(); },
            "int: surfaces that the program itself wants machined.")
        .def("write", &write, py::arg("path"), write_doc)
        .def("text", &text, text_doc)
        .def("translate", &translate, py::arg("machine"), py::arg("setup") = py::none(), py::arg("law") = "vector",
             py::arg("precision_deg") = 0.001, translate_doc)
        .def("expand_surfaces", &expand_surfaces, py::arg("setup") = py::none(), expand_surfaces_doc)
        .def("__repr__",
             [](const Program& p) { return fmt::format("<trunnion.Program {}: {} moves>", p.name, p.moves.size()); });
}

}  // namespace

constexpr const char* read_program_doc = R"(read_program(path, **options)
--

Reads a part program, plain or gzip'd. The GIL is released.

Parameters
----------
path : str or os.PathLike
machine : Machine, optional
    Rotary words and words of one control need it.
dialect : {'apt', 'rs274', 'sinumerik', 'heidenhain', 'fanuc'}, optional
    Default: recognised by content.
units : {'mm', 'inch'}, optional
    Overrides what the program states.
feed_given_elsewhere : bool
    A missing feed is no error; `plan(..., feed_mm_min=…)` gives it.

Returns
-------
Program

Raises
------
Error
    codes NC… with file, line and column.)";

constexpr const char* read_program_text_doc = R"(read_program_text(text, **options)
--

Reads a part program from text.

Parameters
----------
text : str
name : str
    What diagnostics call it; 'program'.
machine, dialect, units, feed_given_elsewhere : optional
    As read_program().

Returns
-------
Program

Raises
------
Error
    codes NC… with line and column.)";

constexpr const char* program_from_poses_doc = R"(program_from_poses(tips, axes=None, **options)
--

A program of straight moves through poses; line numbers count the poses from 1.

Parameters
----------
tips : array_like, shape (n, 3)
    Tip in the workpiece, mm; the first is where motion starts.
axes : array_like, shape (n, 3), optional
    Unit tool axes to 1e-6, tip to spindle (law vector). None: along Z of the workpiece throughout, as of a program for
    three axes. Not with `rotary_letters`.
feed_mm_min : float or array_like, shape (n,)
    Speed of the tip on the way to each pose; that of the first pose and of rapids does not count.
rapid : array_like of bool, shape (n,), optional
exact_stop : array_like of bool, shape (n,), optional
rotary_letters : str, optional
    Literal rotary words instead of axes (law rotary), such as 'AC'; needs a machine that has them.
rotary_deg : array_like, shape (n, letters), optional
    The words, degrees.
name : str, optional

Returns
-------
Program

Raises
------
Error
    PY0001 to PY0004 by the argument's name.)";

void bind_program(py::module_& module) {
    bind_program_class(module);
    module.def(
        "read_program", [](py::handle path, const py::kwargs& given) { return read_program(path, false, given); },
        py::arg("path"), read_program_doc);
    module.def(
        "read_program_text", [](py::handle text, const py::kwargs& given) { return read_program(text, true, given); },
        py::arg("text"), read_program_text_doc);
    module.def("program_from_poses", &program_from_poses, py::arg("tips"), py::arg("axes") = py::none(),
               program_from_poses_doc);
}

}  // namespace trunnion::python
