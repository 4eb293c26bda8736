#include "detail/sinumerik_interpreter.hpp"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "detail/sinumerik_interpreter_machinery.hpp"

namespace trunnion::nc::sinumerik {

namespace {

/// Addresses whose number before the = says which spindle, tool or group is meant.
constexpr std::string_view extended_addresses = "MSHTD";

constexpr std::pair<std::string_view, Counting> countings[] = {{"AC", Counting::absolute},
                                                               {"IC", Counting::incremental},
                                                               {"DC", Counting::shortest},
                                                               {"ACP", Counting::positive},
                                                               {"ACN", Counting::negative}};

constexpr std::string_view polynomial = "PO";

/// What else means something within statements.
constexpr std::string_view inner_words[] = {"TO", "OF", "DEFAULT", "SET", "REP", "VAR", "BLOCK", "ENDLABEL"};

const std::pair<std::string_view, Counting>* counting_named(std::string_view name) {
    const auto* const found = std::ranges::find(countings, name, &std::pair<std::string_view, Counting>::first);
    return found == std::end(countings) ? nullptr : found;
}

}  // namespace

Interpreter::Interpreter(const ProgramText& text, std::string_view file_name, Findings& findings,
                         bool (*is_word)(std::string_view), const Limits& limits)
    : machinery_(std::make_unique<Machinery>(text, file_name, findings, is_word, limits)) {}

Interpreter::~Interpreter() = default;

Interpreter::Step Interpreter::next(Block& block) {
    return machinery_->next(block);
}

const ProgramText& Interpreter::text() const {
    return machinery_->text();
}

std::size_t Interpreter::position() const {
    return machinery_->position();
}

Interpreter::Machinery::Machinery(const ProgramText& text, std::string_view file_name, Findings& findings,
                                  bool (*is_word)(std::string_view), const Limits& limits)
    : findings_(findings),
      is_word_(is_word),
      limits_(limits),
      lines_left_(limits.lines),
      elements_left_(limits.array_elements),
      main_({}, text),
      folder_(file_name),
      cursor_(findings),
      expressions_(cursor_, variables_, limits.brackets) {
    Frame& main = frames_.emplace_back();
    main.program = {&main_, &main_.main_section()};
    main.next = main.program.section->begin;
    variables_.enter(main.scope);
}

Interpreter::Step Interpreter::Machinery::next(Block& block) {
    block.words.clear();
    while (!ended_) {
        if (turn_back(frame())) continue;
        if (!frame().program.source->is_before_end(frame().next, *frame().program.section)) {
            if (!leave()) return Step::refused;
            continue;
        }
        if (!carry_out(block)) return Step::refused;
        if (!block.words.empty()) return Step::block;
    }
    return Step::end;
}

bool Interpreter::Machinery::charge_line() {
    return --lines_left_ >= 0 ||
           refuse("NC0542", 1, "the program does not come to an end", {},
                  fmt::format("{} lines were carried out again or in subprograms", limits_.lines));
}

bool Interpreter::Machinery::carry_out(Block& block) {
    Frame& running = frame();
    Source& source = *running.program.source;
    here_.at = running.next;
    source.take_line(running.next, line_);
    here_.behind = running.next;
    const bool is_new = frames_.size() == 1 && here_.behind.offset > furthest_.offset;
    if (is_new) furthest_ = here_.behind;
    cursor_.start(line_.capitals, line_.original, here_.at.line, source.file());
    block.line = running.outer_line > 0 ? running.outer_line : here_.at.line;
    block.place = cursor_.spot(1);
    block.label = {};
    if ((!is_new && !charge_line()) || !begin_line(block)) return false;
    while (!line_done_ && !cursor_.at_end()) {
        if (!word(block)) return false;
        first_ = false;
    }
    return !leaving_ || leave();
}

/// Block delete, block number and label.
bool Interpreter::Machinery::begin_line(Block& block) {
    first_ = true;
    leaving_ = false;
    line_done_ = false;
    const char c = cursor_.front();
    if (c == '/') {
        findings_.count("NC0016", Severity::warning, cursor_.spot(cursor_.column()), "/",
                        "block skipped, as block delete asks for", "take the slash away if it shall be read");
        line_done_ = true;
        return true;
    }
    if (c == '%') line_done_ = true;  // a mark of tapes: with a name it would have started a section
    const std::string_view rest = cursor_.rest();
    if ((c == 'N' || c == ':') && rest.size() > 1 && is_digit(rest[1]))
        cursor_.advance(std::min(rest.find_first_not_of("0123456789", 1), rest.size()));
    if (line_done_ || cursor_.at_end()) return true;
    opens_program_ = !std::exchange(frame().begun, true);
    const std::string_view label = cursor_.peek_name();
    if (is_own_name(label) && cursor_.rest().substr(label.size()).starts_with(':')) {
        cursor_.advance(label.size() + 1);
        block.label = label;
    }
    if (opens_program_ && !frame().passed.empty() && cursor_.peek_name() != "PROC")
        return refuse("NC0534", 1, "values are handed to a subprogram that takes none", {},
                      "PROC in its first line names what it takes");
    return true;
}

bool Interpreter::Machinery::word(Block& block) {
    const std::string_view rest = cursor_.rest();
    const char c = rest.front();
    const int column = cursor_.column();
    if (is_letter(c) && rest.size() > 1 && starts_number(rest[1]) && c != 'R' && c != 'L')
        return plain_word(block, column);
    if (c == 'L' && rest.size() > 1 && is_digit(rest[1])) {
        const std::string_view name = rest.substr(0, rest.find_first_not_of("0123456789", 1));
        cursor_.advance(name.size());
        return call(name, block, column);
    }
    if (is_letter(c) || c == '_' || c == '$') return named_word(block, column);
    return cursor_.refuse_here();
}

Word* Interpreter::Machinery::add_word(Block& block, std::string_view name, int column) {
    if (block.words.size() == static_cast<std::size_t>(limits_.words)) {
        refuse("NC0545", column, "too many words in a block", {}, fmt::format("at most {}", limits_.words));
        return nullptr;
    }
    Word& word = block.words.emplace_back();
    word.name = name;
    word.column = column;
    return &word;
}

/// A letter and a number, as nearly all words are.
bool Interpreter::Machinery::plain_word(Block& block, int column) {
    const std::string_view written = cursor_.rest();
    const std::size_t digits = std::min(written.find_first_not_of("0123456789", 1), written.size());
    cursor_.advance(digits < written.size() && written[digits] == '=' ? digits : 1);
    if (cursor_.rest().starts_with('='))
        return extended_word(block, column, written.substr(0, 1), written.substr(1, digits - 1));
    const auto value = cursor_.number();
    if (!value) return refuse("NC0201", column, "no finite number behind the letter", written.substr(0, 12));
    if (cursor_.sees("=")) {
        const std::size_t end = written.find_first_not_of("0123456789", 1);
        if (!skip_blanks(written.substr(end)).starts_with('=')) return cursor_.refuse_here();
        return extended_word(block, column, written.substr(0, 1), written.substr(1, end - 1));
    }
    Word* const word = add_word(block, written.substr(0, 1), column);
    if (!word) return false;
    word->has_value = true;
    word->value = *value;
    if (!ends_program(*word)) return true;
    leaving_ = true;
    if (frames_.size() > 1) block.words.pop_back();
    return true;
}

bool Interpreter::Machinery::ends_program(const Word& word) const {
    return word.name == "M" && (word.value == 2 || word.value == 17 || word.value == 30);
}

/// A letter with digits in front of the =.
bool Interpreter::Machinery::extended_word(Block& block, int column, std::string_view letter, std::string_view digits) {
    Word* const word = add_word(block, letter, column);
    if (!word) return false;
    if (extended_addresses.contains(letter)) {
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), word->extension);
        if (error != std::errc{}) return refuse("NC0201", column, "too large a number in front of the =", letter);
    } else {
        word->name = {letter.data(), letter.size() + digits.size()};
    }
    cursor_.take("=");
    return value_of(*word);
}

bool Interpreter::Machinery::named_word(Block& block, int column) {
    const std::string_view name = cursor_.name();
    if (name.empty()) return cursor_.refuse_here();
    if (name[0] == '$') return system_variable(name, column);
    if (const Statement statement = statement_named(name)) return (this->*statement)(block, column);
    if (expressions_.is_variable(name)) return assign(name, column);
    if (is_word_(name) || (name.size() == 1 && is_letter(name[0]))) return control_word(block, column, name);
    if (cursor_.sees("=") || cursor_.sees("["))
        return refuse("NC0502", column, "no such variable in this program", name,
                      "DEF makes one; variables of a calling program are not seen within a subprogram");
    return call(name, block, column);
}

bool Interpreter::Machinery::control_word(Block& block, int column, std::string_view name) {
    Word* const word = add_word(block, name, column);
    if (!word) return false;
    if (cursor_.take("[") && !index_of(*word)) return false;
    if (cursor_.take("=")) return value_of(*word);
    if (cursor_.take("(")) {
        word->is_call = true;
        return expressions_.arguments(word->arguments, limits_.words);
    }
    if (name.size() > 1 || !word->index.empty()) return true;
    const auto value = cursor_.number();
    if (!value) return refuse("NC0201", column, "no finite number behind the letter", name);
    word->has_value = true;
    word->value = *value;
    return true;
}

bool Interpreter::Machinery::index_of(Word& word) {
    std::string_view axis;
    if (word.name == polynomial && cursor_.take("]")) return true;  // PO[]: the denominator
    if (expressions_.bare_name(axis)) {
        word.index = axis;
    } else {
        Value index;
        if (!expressions_.value(index)) return false;
        word.index = written(index);
    }
    return cursor_.want("]");
}

/// A number behind which the next word begins, or nothing: the values of nearly all words. Else nothing is taken.
std::optional<double> Interpreter::Machinery::number_alone() {
    Cursor ahead = cursor_;
    const auto value = ahead.number();
    if (!value) return {};
    const bool ends = ahead.at_end();
    const std::string_view rest = ahead.rest();
    if (!ends && !(is_letter(rest[0]) && rest.size() > 1 && (is_digit(rest[1]) || rest[1] == '='))) return {};
    cursor_ = ahead;
    return value;
}

/// Behind the =.
bool Interpreter::Machinery::value_of(Word& word) {
    if (const auto value = number_alone(); value && word.name != polynomial) {
        word.has_value = true;
        word.value = *value;
        return true;
    }
    if (word.name == polynomial || cursor_.take_word(polynomial)) {
        word.is_list = true;
        return cursor_.want("(") && expressions_.arguments(word.arguments, limits_.words);
    }
    if (const auto* const counting = counting_named(cursor_.peek_name())) {
        cursor_.name();
        word.counting = counting->second;
        word.has_value = true;
        return cursor_.want("(") && expressions_.number(word.value) && cursor_.want(")");
    }
    Value value;
    if (!expressions_.value(value)) return false;
    word.has_value = value.kind == Value::Kind::number;
    word.has_text = !word.has_value;
    word.value = value.number;
    word.text = std::move(value.text);
    return true;
}

/// Whether a variable cannot have this name.
bool Interpreter::Machinery::is_taken(std::string_view name) const {
    return statement_named(name) || is_word_(name) || is_expression_word(name) || type_named(name).has_value() ||
           counting_named(name) || std::ranges::find(inner_words, name) != std::end(inner_words);
}

}  // namespace trunnion::nc::sinumerik
