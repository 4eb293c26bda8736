#include "detail/sinumerik_flow.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "detail/sinumerik_text.hpp"

namespace trunnion::nc::sinumerik {

namespace {

std::string_view opening_word(Structure::Kind kind) {
    switch (kind) {
        case Structure::Kind::choice:
            return "IF";
        case Structure::Kind::count:
            return "FOR";
        case Structure::Kind::condition_first:
            return "WHILE";
        case Structure::Kind::condition_last:
            return "REPEAT";
        case Structure::Kind::endless:
            return "LOOP";
    }
    return "LOOP";
}

}  // namespace

bool FlowIndex::build(const Source& source, const Section& section, Cursor& cursor) {
    Source text = source.again();
    CapitalLine line;
    LinePlace place = section.begin;
    while (text.is_before_end(place, section)) {
        LineMark mark{place, {}};
        text.take_line(place, line);
        mark.behind = place;
        cursor.start(line.capitals, line.original, mark.at.line, source.file());
        if (!read_line(cursor, mark)) return false;
    }
    if (open_.empty()) return true;
    const Structure& left = structures_[static_cast<std::size_t>(open_.back())];
    cursor.start({}, nullptr, left.begin.at.line, source.file());
    return cursor.refuse("NC0522", 1, "this control structure has no end", opening_word(left.kind));
}

/// What a line says about the flow: its number, its label, a control structure. Lines behind a / say nothing.
bool FlowIndex::read_line(Cursor& cursor, const LineMark& mark) {
    const auto add_target = [&](std::string_view name) {
        targets_[std::string(name)].push_back({mark, open_.empty() ? -1 : open_.back()});
    };
    if (cursor.front() == '/') return true;
    std::string_view word = cursor.name();
    if (word.size() > 1 && word[0] == 'N' && is_digit(word[1])) {
        if (block_numbers_.contains(word)) add_target(word);
        word = cursor.name();
    }
    if (is_own_name(word) && cursor.sees(":")) {
        cursor.take(":");
        add_target(word);
        word = cursor.name();
    }
    const int column = 1 + static_cast<int>(word.data() - cursor.line().data());
    using Kind = Structure::Kind;
    if (word == "IF") return cursor.has_jump() || open(Kind::choice, mark);
    if (word == "FOR") return open(Kind::count, mark);
    if (word == "WHILE") return open(Kind::condition_first, mark);
    if (word == "LOOP") return open(Kind::endless, mark);
    if (word == "REPEAT") return !cursor.at_end() || open(Kind::condition_last, mark);
    if (word == "ELSE") return divide(mark, cursor, column);
    if (word == "ENDIF") return close(Kind::choice, mark, cursor, column, word);
    if (word == "ENDFOR") return close(Kind::count, mark, cursor, column, word);
    if (word == "ENDWHILE") return close(Kind::condition_first, mark, cursor, column, word);
    if (word == "UNTIL") return close(Kind::condition_last, mark, cursor, column, word);
    if (word == "ENDLOOP") return close(Kind::endless, mark, cursor, column, word);
    return true;
}

bool FlowIndex::open(Structure::Kind kind, const LineMark& mark) {
    const int number = static_cast<int>(structures_.size());
    structures_.push_back(
        {.kind = kind, .begin = mark, .middle = {}, .end = {}, .outer = open_.empty() ? -1 : open_.back()});
    by_line_[mark.at.offset] = number;
    open_.push_back(number);
    return true;
}

bool FlowIndex::divide(const LineMark& mark, Cursor& cursor, int column) {
    if (open_.empty()) return cursor.refuse("NC0522", column, "ELSE without IF");
    Structure& inner = structures_[static_cast<std::size_t>(open_.back())];
    if (inner.kind != Structure::Kind::choice || inner.has_middle)
        return cursor.refuse("NC0522", column, "ELSE without IF", {},
                             fmt::format("{} of line {} is still open", opening_word(inner.kind), inner.begin.at.line));
    inner.has_middle = true;
    inner.middle = mark;
    by_line_[mark.at.offset] = open_.back();
    return true;
}

bool FlowIndex::close(Structure::Kind kind, const LineMark& mark, Cursor& cursor, int column, std::string_view word) {
    if (open_.empty()) return cursor.refuse("NC0522", column, fmt::format("{} without {}", word, opening_word(kind)));
    Structure& inner = structures_[static_cast<std::size_t>(open_.back())];
    if (inner.kind != kind)
        return cursor.refuse("NC0522", column, fmt::format("{} without {}", word, opening_word(kind)), {},
                             fmt::format("{} of line {} is still open", opening_word(inner.kind), inner.begin.at.line));
    inner.end = mark;
    by_line_[mark.at.offset] = open_.back();
    open_.pop_back();
    return true;
}

const Structure* FlowIndex::structure_at(std::size_t offset) const {
    const auto found = by_line_.find(offset);
    return found == by_line_.end() ? nullptr : &structures_[static_cast<std::size_t>(found->second)];
}

const Target* FlowIndex::find(std::string_view name, Direction direction, std::size_t from) const {
    const auto found = targets_.find(name);
    if (found == targets_.end()) return nullptr;
    const std::vector<Target>& targets = found->second;
    const auto behind = std::ranges::upper_bound(targets, from, {}, [](const Target& t) { return t.line.at.offset; });
    const Target* const forward = behind == targets.end() ? nullptr : &*behind;
    const Target* const backward = behind == targets.begin() ? nullptr : &*(behind - 1);
    switch (direction) {
        case Direction::forward:
            return forward;
        case Direction::backward:
            return backward;
        case Direction::forward_first:
            return forward ? forward : backward;
        case Direction::backward_first:
            return backward ? backward : forward;
    }
    return nullptr;
}

bool FlowIndex::enters_structure(const Target& target, std::size_t from) const {
    if (target.structure < 0) return false;
    const Structure& innermost = structures_[static_cast<std::size_t>(target.structure)];
    return from < innermost.begin.at.offset || from > innermost.end.at.offset;
}

}  // namespace trunnion::nc::sinumerik
