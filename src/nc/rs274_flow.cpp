#include "detail/rs274_flow.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace trunnion::nc {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_arguments = 30;
constexpr double most_times = 1e9;
constexpr std::size_t most_structures = 64;  ///< within each other
constexpr std::uintmax_t longest_file = 1u << 28;

constexpr std::pair<std::string_view, FlowKeyword> keywords[] = {
    {"SUB", FlowKeyword::sub},
    {"ENDSUB", FlowKeyword::end_sub},
    {"CALL", FlowKeyword::call},
    {"RETURN", FlowKeyword::give_back},
    {"IF", FlowKeyword::when},
    {"ELSEIF", FlowKeyword::else_when},
    {"ELSE", FlowKeyword::otherwise},
    {"ENDIF", FlowKeyword::end_when},
    {"WHILE", FlowKeyword::loop_while},
    {"ENDWHILE", FlowKeyword::end_while},
    {"DO", FlowKeyword::loop_do},
    {"REPEAT", FlowKeyword::repeat},
    {"ENDREPEAT", FlowKeyword::end_repeat},
    {"BREAK", FlowKeyword::leave_loop},
    {"CONTINUE", FlowKeyword::next_turn},
};

/// The label that the cursor stands on, without blanks, in small letters, numbers without leading zeros.
bool take_label(LineCursor& cursor, std::string& label) {
    label.clear();
    if (cursor.take('<')) {
        const std::size_t end = cursor.rest.find('>');
        if (end == cursor.rest.npos) return false;
        for (const char c : cursor.rest.substr(0, end))
            if (!is_blank(c)) label += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        cursor.rest.remove_prefix(end + 1);
        return !label.empty();
    }
    while (is_digit(cursor.front())) {
        if (label == "0") label.clear();
        label += cursor.front();
        cursor.rest.remove_prefix(1);
    }
    return !label.empty();
}

std::optional<FlowKeyword> take_keyword(LineCursor& cursor) {
    const UpperWord word((cursor.front(), cursor.rest));
    const auto* const found =
        std::ranges::find(keywords, word.text(), &std::pair<std::string_view, FlowKeyword>::first);
    if (found == std::end(keywords)) return {};
    cursor.rest.remove_prefix(word.text().size());
    return found->second;
}

/// The line behind blanks and a block number, if an O word comes there.
bool goes_to_o_word(LineCursor& cursor) {
    if (upper(cursor.front()) == 'N') {
        cursor.rest.remove_prefix(1);
        while (is_digit(cursor.front()) || cursor.front() == '.') cursor.rest.remove_prefix(1);
    }
    if (upper(cursor.front()) != 'O') return false;
    cursor.rest.remove_prefix(1);
    return true;
}

bool starts_loop(FlowKeyword keyword) {
    return keyword == FlowKeyword::loop_while || keyword == FlowKeyword::loop_do || keyword == FlowKeyword::repeat;
}

/// The keyword by which this one may be ended.
bool ends(FlowKeyword head, FlowKeyword end) {
    switch (end) {
        case FlowKeyword::end_sub:
            return head == FlowKeyword::sub;
        case FlowKeyword::else_when:
        case FlowKeyword::otherwise:
        case FlowKeyword::end_when:
            return head == FlowKeyword::when;
        case FlowKeyword::end_while:
            return head == FlowKeyword::loop_while;
        case FlowKeyword::loop_while:
            return head == FlowKeyword::loop_do;
        default:
            return head == FlowKeyword::repeat;
    }
}

}  // namespace

std::optional<FlowIndex> FlowIndex::make(const ProgramText& text, std::string_view file, Findings& findings) {
    FlowIndex index;
    LineScanner lines(text.again());
    for (std::string_view line; lines.next(line);) {
        LineCursor cursor{line, line, lines.number(), file};
        if (!goes_to_o_word(cursor)) continue;
        FlowLine found;
        found.start = static_cast<std::size_t>(line.data() - text.view().data());
        found.behind = lines.offset();
        found.number = lines.number();
        if (const char c = cursor.front(); c == '[' || c == '#') {
            found.keyword = FlowKeyword::call;
        } else {
            if (!take_label(cursor, found.label)) {
                findings.refuse("NC0331", cursor.spot(), "an O word without its number or name",
                                cursor.rest.substr(0, 12));
                return {};
            }
            if (is_letter(cursor.front())) {
                const auto keyword = take_keyword(cursor);
                if (!keyword) {
                    findings.refuse("NC0331", cursor.spot(), "no such word behind an O", cursor.rest.substr(0, 12));
                    return {};
                }
                found.keyword = *keyword;
            }
        }
        index.lines_.push_back(std::move(found));
    }
    if (!index.match(file, findings)) return {};
    return index;
}

/// Structures lie within each other and within their subprogram.
bool FlowIndex::match(std::string_view file, Findings& findings) {
    std::vector<std::size_t> open;
    const auto refuse = [&](const FlowLine& line, std::string text) {
        return findings.refuse("NC0332", {line.number, 1, file}, std::move(text), "o" + line.label);
    };
    const auto close_part = [&](std::size_t part) {
        FlowLine& head = lines_[lines_[part].head];
        lines_[head.end].next_part = part;
        head.end = part;
    };
    const auto close = [&](std::size_t end) {
        const std::size_t head = lines_[end].head;
        lines_[head].end = lines_[end].end = end;
        for (std::size_t part = lines_[head].next_part; part != 0; part = lines_[part].next_part)
            lines_[part].end = end;
    };
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        FlowLine& line = lines_[i];
        const bool inner = !open.empty() && lines_[open.back()].label == line.label;
        switch (line.keyword) {
            case FlowKeyword::program:
            case FlowKeyword::call:
            case FlowKeyword::give_back:
            case FlowKeyword::leave_loop:
            case FlowKeyword::next_turn:
                continue;
            case FlowKeyword::sub:
                if (!open.empty()) return refuse(line, "a subprogram within another structure");
                break;
            case FlowKeyword::loop_while:
                if (inner && ends(lines_[open.back()].keyword, line.keyword)) {
                    line.head = open.back();
                    close(i);
                    open.pop_back();
                    continue;
                }
                break;
            case FlowKeyword::when:
            case FlowKeyword::loop_do:
            case FlowKeyword::repeat:
                break;
            default:
                if (!inner || !ends(lines_[open.back()].keyword, line.keyword))
                    return refuse(line, "the end or part of a structure that is not open here");
                line.head = open.back();
                if (lines_[line.head].keyword == FlowKeyword::when) close_part(i);
                if (line.keyword != FlowKeyword::else_when && line.keyword != FlowKeyword::otherwise) {
                    close(i);
                    open.pop_back();
                }
                continue;
        }
        line.head = line.end = i;
        open.push_back(i);
        if (open.size() > most_structures) return refuse(line, "too many structures within each other");
    }
    if (!open.empty()) return refuse(lines_[open.back()], "a structure without its end");
    return true;
}

std::size_t FlowIndex::at(std::size_t start) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(lines_, start, {}, &FlowLine::start) - lines_.begin());
}

std::optional<std::size_t> FlowIndex::subprogram(std::string_view label, FlowKeyword kind) const {
    for (std::size_t i = 0; i < lines_.size(); ++i)
        if (lines_[i].keyword == kind && lines_[i].label == label) return i;
    return {};
}

Rs274Flow::Rs274Flow(const ProgramText& text, std::string_view file_name, const ControlParameters& control,
                     Findings& findings, std::int64_t most_repeated_lines)
    : findings_(findings), scanner_(parameters_, control, findings), lines_left_(most_repeated_lines) {
    std::error_code error;
    if (fs::is_regular_file(file_name, error)) folder_ = fs::absolute(file_name, error).parent_path();
    main_.text = text;
    frames_.push_back({.source = &main_});
}

std::string_view Rs274Flow::take_line() {
    Frame& frame = frames_.back();
    frame.line = number_behind(frame.line);
    return frame.source->text.line(frame.next, frame.next);
}

/// The text once is free.
bool Rs274Flow::count_line(std::size_t start) {
    if (frames_.size() == 1 && start >= furthest_) {
        furthest_ = frames_.back().next;
        return true;
    }
    return --lines_left_ >= 0;
}

bool Rs274Flow::has_subprograms() const {
    return main_.index && std::ranges::any_of(main_.index->lines(), [](const FlowLine& line) {
               return line.keyword == FlowKeyword::sub || line.keyword == FlowKeyword::program;
           });
}

std::string_view Rs274Flow::rest() const {
    return frames_.size() > 1 ? std::string_view{}
                              : main_.text.view().substr(std::min(frames_.back().next, main_.text.size()));
}

Rs274Flow::Step Rs274Flow::next(Block& block) {
    for (;;) {
        const Frame& frame = frames_.back();
        const std::size_t start = frame.next;
        const bool at_end = start >= frame.source->text.size();
        if (at_end && frames_.size() == 1) return Step::end;
        if (at_end) {
            refuse({{}, {}, frame.line, frame.source->file}, "NC0335", "the text ends within a subprogram", {},
                   "M99 or endsub ends it");
            return Step::refused;
        }
        const std::string_view line = take_line();
        LineCursor cursor{line, skip_blanks(line), frame.line, frame.source->file};
        block.program_line = frame.outer_line != 0 ? frame.outer_line : frame.line;
        if (!count_line(start)) {
            refuse(cursor, "NC0338", "the program carries out too many lines again: it may have no end", {},
                   "check the conditions of its loops");
            return Step::refused;
        }
        if (cursor.rest.starts_with('%')) {
            if (frames_.size() == 1 && ++percent_signs_ == 2) return Step::end;
            continue;
        }
        switch (scanner_.scan(cursor, block)) {
            case BlockScanner::Found::words:
                return Step::block;
            case BlockScanner::Found::refused:
                return Step::refused;
            case BlockScanner::Found::o_word:
                if (!flow(cursor, block)) return Step::refused;
                break;
        }
    }
}

bool Rs274Flow::flow(LineCursor& cursor, Block& block) {
    Source& source = *frames_.back().source;
    const FlowIndex* const index = index_of(source);
    if (!index) return false;
    const auto start = static_cast<std::size_t>(cursor.line.data() - source.text.view().data());
    const std::size_t here = index->at(start);
    if (here == index->lines().size() || index->lines()[here].start != start)
        return refuse(cursor, "NC0331", "an O word stands first in its line");
    const FlowLine& line = index->lines()[here];
    block.line = cursor.number;
    block.file = cursor.file;
    std::string label = line.label;
    if (label.empty()) {
        ParameterValue number;
        if (!scanner_.expressions().value(cursor, number)) return false;
        const double whole = std::round(*number);
        if (!(std::abs(*number - whole) < 1e-4) || whole < 0 || whole > most_times)
            return refuse(cursor, "NC0331", "an O word has a whole number", fmt::format("{}", *number));
        label = fmt::format("{:.0f}", whole);
        if (take_keyword(cursor) != FlowKeyword::call)
            return refuse(cursor, "NC0331", "a computed O word can only be called", cursor.rest.substr(0, 12));
    } else {
        take_label(cursor, label);
        if (line.keyword != FlowKeyword::program) take_keyword(cursor);
    }
    return carry_out(cursor, line, here, label);
}

bool Rs274Flow::carry_out(LineCursor& cursor, const FlowLine& line, std::size_t index, const std::string& label) {
    switch (line.keyword) {
        case FlowKeyword::program:
            return scanner_.at_end(cursor);
        case FlowKeyword::sub:
            go_behind(frames_.back().source->index->lines()[line.end]);
            return true;
        case FlowKeyword::end_sub:
        case FlowKeyword::give_back:
            return give_back(cursor);
        case FlowKeyword::call:
            return call(cursor, label);
        case FlowKeyword::when:
            return branch(cursor, index);
        case FlowKeyword::else_when:
        case FlowKeyword::otherwise:
            go_behind(frames_.back().source->index->lines()[line.end]);  // the part before it was carried out
            return true;
        case FlowKeyword::end_when:
            return scanner_.at_end(cursor);
        default:
            return loop(cursor, line, index);
    }
}

/// From an if whose condition is asked to the part that is carried out.
bool Rs274Flow::branch(LineCursor& cursor, std::size_t index) {
    const std::vector<FlowLine>& lines = frames_.back().source->index->lines();
    bool holds = false;
    if (!condition(cursor, holds)) return false;
    while (!holds) {
        index = lines[index].next_part;
        go_behind(lines[index]);
        if (lines[index].keyword != FlowKeyword::else_when) return true;
        const std::string_view line =
            frames_.back().source->text.view().substr(lines[index].start, lines[index].behind - lines[index].start);
        const std::string_view bare = line.substr(0, line.find('\n'));
        LineCursor part{bare, bare, lines[index].number, cursor.file};
        std::string label;
        goes_to_o_word(part);
        take_label(part, label);
        take_keyword(part);
        if (!condition(part, holds)) return false;
    }
    return true;
}

bool Rs274Flow::loop(LineCursor& cursor, const FlowLine& line, std::size_t index) {
    const std::vector<FlowLine>& lines = frames_.back().source->index->lines();
    std::map<std::size_t, double>& repetitions = frames_.back().repetitions;
    bool holds = false;
    std::size_t head = line.head;
    switch (line.keyword) {
        case FlowKeyword::loop_while:
            if (!condition(cursor, holds)) return false;
            if (head != index && holds) go_behind(lines[head]);       // the end of do
            if (head == index && !holds) go_behind(lines[line.end]);  // the start of while
            return true;
        case FlowKeyword::end_while:
            go_to(lines[head]);
            break;
        case FlowKeyword::loop_do:
            break;
        case FlowKeyword::repeat: {
            ParameterValue times;
            if (!scanner_.expressions().bracketed(cursor, times)) return false;
            const double turns = std::round(*times);
            if (!(std::abs(*times - turns) < 1e-4) || turns > most_times)
                return refuse(cursor, "NC0339", "a repetition has a whole number of turns", fmt::format("{}", *times));
            if (turns < 1)
                go_behind(lines[line.end]);
            else
                repetitions[index] = turns - 1;
            break;
        }
        case FlowKeyword::end_repeat: {
            const auto left = repetitions.find(head);
            if (left != repetitions.end() && left->second-- >= 1) go_behind(lines[head]);
            break;
        }
        case FlowKeyword::leave_loop:
            if (!enclosing_loop(cursor, line.label, index, head)) return false;
            go_behind(lines[lines[head].end]);
            break;
        default:
            if (!enclosing_loop(cursor, line.label, index, head)) return false;
            go_to(lines[lines[head].end]);
            break;
    }
    return scanner_.at_end(cursor);
}

/// The loop of this label around a break or continue.
bool Rs274Flow::enclosing_loop(const LineCursor& cursor, const std::string& label, std::size_t index,
                               std::size_t& head) {
    const std::vector<FlowLine>& lines = frames_.back().source->index->lines();
    for (std::size_t i = index; i-- > 0 && lines[i].keyword != FlowKeyword::sub;) {
        if (lines[i].label != label || lines[i].head != i || !starts_loop(lines[i].keyword) || lines[i].end < index)
            continue;
        head = i;
        return true;
    }
    return refuse(cursor, "NC0337", "break and continue stand within the loop of their number", "o" + label);
}

bool Rs274Flow::condition(LineCursor& cursor, bool& result) {
    ParameterValue value;
    if (!scanner_.expressions().bracketed(cursor, value)) return false;
    result = *value != 0;
    return scanner_.at_end(cursor);
}

bool Rs274Flow::call(LineCursor& cursor, const std::string& label) {
    std::vector<ParameterValue> arguments;
    while (cursor.front() == '[') {
        if (arguments.size() == most_arguments)
            return refuse(cursor, "NC0340", "too many arguments", {}, fmt::format("at most {}", most_arguments));
        if (!scanner_.expressions().bracketed(cursor, arguments.emplace_back())) return false;
    }
    Frame frame{.has_locals = true};
    if (!scanner_.at_end(cursor) || !enter(cursor.spot(1), label, FlowKeyword::sub, frame)) return false;
    parameters_.enter();
    for (std::size_t i = 0; i < arguments.size(); ++i) parameters_.set({static_cast<int>(i) + 1}, arguments[i]);
    frames_.push_back(std::move(frame));
    return true;
}

bool Rs274Flow::give_back(LineCursor& cursor) {
    ParameterValue value = 0;
    const bool given = cursor.front() == '[';
    if (given && !scanner_.expressions().bracketed(cursor, value)) return false;
    if (!scanner_.at_end(cursor)) return false;
    if (frames_.size() == 1 || !frames_.back().has_locals)
        return refuse(cursor, "NC0337", "return and endsub stand within a subprogram that call began", {},
                      "M99 ends one that M98 began");
    parameters_.leave();
    frames_.pop_back();
    parameters_.set({.name = "_value"}, value);
    parameters_.set({.name = "_value_returned"}, given ? 1 : 0);
    return true;
}

/// Where the subprogram starts: in the running text, in the text that is read, or in a file of the folder.
bool Rs274Flow::enter(Spot spot, const std::string& label, FlowKeyword kind, Frame& frame) {
    if (depth() == most_calls)
        return findings_.refuse("NC0336", spot, "too many subprograms within each other", {},
                                fmt::format("at most {}", most_calls));
    const Frame& caller = frames_.back();
    Source* sources[] = {caller.source, &main_, nullptr};
    for (Source*& source : sources) {
        if (!source) source = read_file(spot, label);
        if (!source) return false;
        const FlowIndex* const index = index_of(*source);
        if (!index) return false;
        const auto found = index->subprogram(label, kind);
        const bool whole_file = !found && kind == FlowKeyword::program && &source == &sources[2];
        if (!found && !whole_file) continue;
        frame.source = source;
        frame.first = found ? index->lines()[*found].behind : 0;
        frame.first_line = found ? index->lines()[*found].number : 0;
        frame.next = frame.first;
        frame.line = frame.first_line;
        if (!source->file.empty()) frame.outer_line = caller.outer_line != 0 ? caller.outer_line : caller.line;
        return true;
    }
    return findings_.refuse("NC0333", spot, "no such subprogram in this file", "o" + label);
}

Rs274Flow::Source* Rs274Flow::read_file(Spot spot, const std::string& label) {
    if (const auto found = files_.find(label); found != files_.end()) return found->second.get();
    const auto refused = [&](std::string_view code, std::string text, std::string_view hint = {}) {
        findings_.refuse(code, spot, std::move(text), "o" + label, hint);
        return nullptr;
    };
    const bool plain = std::ranges::all_of(
        label, [](char c) { return is_letter(c) || is_digit(c) || c == '_' || c == '-' || c == '+'; });
    if (!plain) return refused("NC0334", "the name of a subprogram leads out of the program's folder");
    std::error_code error;
    const fs::path file = folder_ / (label + ".ngc");
    if (folder_.empty() || !fs::is_regular_file(file, error))
        return refused("NC0333", "no such subprogram", "sub begins it, in this text or in a file of its folder");
    const fs::path place = fs::canonical(file, error), folder = fs::canonical(folder_, error);
    if (error || place.parent_path() != folder)
        return refused("NC0334", "the file of a subprogram lies out of the program's folder");
    if (const auto size = fs::file_size(file, error); error || size > longest_file)
        return refused("NC0334", "the file of a subprogram is too large");
    std::ifstream in(file, std::ios::binary);
    auto source = std::make_unique<Source>();
    source->file = file.string();
    source->kept.assign(std::istreambuf_iterator<char>(in), {});
    source->text = source->kept;
    if (!in) return refused("NC0334", "the file of a subprogram cannot be read");
    return files_.emplace(label, std::move(source)).first->second.get();
}

const FlowIndex* Rs274Flow::index_of(Source& source) {
    if (!source.index) source.index = FlowIndex::make(source.text, source.file, findings_);
    return source.index ? &*source.index : nullptr;
}

void Rs274Flow::go_behind(const FlowLine& line) {
    frames_.back().next = line.behind;
    frames_.back().line = line.number;
}

void Rs274Flow::go_to(const FlowLine& line) {
    frames_.back().next = line.start;
    frames_.back().line = line.number - 1;
}

bool Rs274Flow::call_program(const Block& block, int column, double number, double times) {
    const Spot spot = block.at(column);
    if (number != std::floor(number) || !(number >= 0) || number > most_times)
        return findings_.refuse("NC0339", spot, "a program has a whole number", fmt::format("P{}", number));
    if (times != std::floor(times) || !(times >= 0) || times > most_times)
        return findings_.refuse("NC0339", spot, "a subprogram runs a whole number of times", fmt::format("L{}", times));
    if (times == 0) return true;
    Frame frame{.times = times};
    if (!enter(spot, fmt::format("{:.0f}", number), FlowKeyword::program, frame)) return false;
    frames_.push_back(std::move(frame));
    return true;
}

bool Rs274Flow::return_from_program(const Block& block, int column) {
    Frame& frame = frames_.back();
    if (frames_.size() == 1 || frame.has_locals)
        return findings_.refuse("NC0337", block.at(column), "M99 without M98: the program would run again and again",
                                "M99", "M2 or M30 ends a program, endsub a subprogram that call began");
    if (--frame.times >= 1) {
        frame.next = frame.first;
        frame.line = frame.first_line;
        frame.repetitions.clear();
    } else {
        frames_.pop_back();
    }
    return true;
}

}  // namespace trunnion::nc
