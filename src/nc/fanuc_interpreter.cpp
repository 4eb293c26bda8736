#include "detail/fanuc_interpreter.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"

#include "detail/text.hpp"

namespace trunnion::nc::fanuc {

namespace {

constexpr int first_of_control = 1000;  ///< variables from here on are the control's own
constexpr int last_of_control = 89999;  ///< those above are common variables again
constexpr double largest_label = 1e8;
constexpr int alarm_variable = 3000, message_variable = 3006;

/// Output signals, clock and single-block switches: none of them moves anything.
bool is_harmless(int variable) {
    return (variable >= 1100 && variable < 1200) || (variable >= 3001 && variable <= 3004) || variable == 3007 ||
           variable == 3011 || variable == 3012;
}

bool is_whole_from(double value, double least, double most) {
    return value >= least && value <= most && value == std::floor(value);
}

}  // namespace

int tenths_of(const Word& word) {
    const double tenths = std::round(word.value * 10);
    const bool good = std::abs(word.value * 10 - tenths) < 1e-6 && tenths >= 0 && tenths < 1e7;
    return good ? static_cast<int>(tenths) : -1;
}

Interpreter::Interpreter(const ProgramText& text, std::string_view file_name, Findings& findings,
                         const ControlParameters& control, const Limits& limits)
    : findings_(findings),
      limits_(limits),
      expressions_(fanuc_parameters, parameters_, control, findings),
      main_(text),
      folder_(file_name) {
    if (main_.beginning().behind_header)
        findings_.count("NC0861", Severity::note, {1, 1}, "header", "the lines before % are no code: passed over");
    const Section section = main_.main_section();
    running_.push_back({.source = &main_, .section = section, .start = section.begin, .at = section.begin});
}

Interpreter::Step Interpreter::next(Block& block) {
    for (;;) {
        Outcome outcome = Outcome::nothing;
        if (pending_) {
            const Call call = *std::exchange(pending_, std::nullopt);
            outcome = carry_out(call);
        } else if (now().at.offset < std::min(now().section.end, now().source->text().size())) {
            outcome = line(block);
        } else {
            outcome = Outcome::section_end;
        }
        if (outcome == Outcome::section_end && running_.size() == 1) return Step::end;
        if (outcome == Outcome::section_end) outcome = give_back({});
        if (outcome == Outcome::refused) return Step::refused;
        if (outcome == Outcome::block) return Step::block;
    }
}

bool Interpreter::code_is_left() const {
    const std::string_view rest = main_.text().view().substr(std::min(position(), main_.text().size()));
    return rest.find_first_not_of("% \t\r\n;") != rest.npos;
}

// --------------------------------------------------------------------------------------------------------------- lines

void Interpreter::begin_line() {
    const Place& at = now().at;
    const std::string_view whole = now().source->line_at(at);
    cursor_.line = whole;
    cursor_.rest = whole.substr(std::min(
        whole.size(), static_cast<std::size_t>(now().source->text().view().data() + at.offset - whole.data())));
    cursor_.number = at.line;
    cursor_.file = now().source->file();
    line_goes_on_ = cursor_.rest.size() != whole.size();
}

/// Lines that were carried out before, and those of subprograms, count towards the limit.
bool Interpreter::count_line() {
    Running& running = now();
    if (running.at.offset < running.furthest || running_.size() > 1) ++repeated_lines_;
    running.furthest = std::max(running.furthest, running.at.offset + 1);
    if (repeated_lines_ <= limits_.lines) return true;
    return refuse("NC0808", cursor_.spot(),
                  fmt::format("more than {} lines again: the program does not end", limits_.lines), {},
                  "the condition of a loop or jump may never change");
}

/// Where the next block begins: behind a `;` in the line, or in the next line.
void Interpreter::go_behind_line() {
    const char* const begin = now().source->text().view().data();
    cursor_.rest = skip_blanks(cursor_.rest);
    if (cursor_.rest.starts_with(';') && !skip_blanks(cursor_.rest.substr(1)).empty())
        now().at.offset = static_cast<std::size_t>(cursor_.rest.data() + 1 - begin);
    else
        now().at = now().source->line_behind(now().at);
}

Interpreter::Outcome Interpreter::line(Block& block) {
    begin_line();
    if (!count_line()) return Outcome::refused;
    const char first = cursor_.front();
    if (first == '%') return Outcome::section_end;
    if (!line_goes_on_ && is_title(cursor_.rest)) {
        if (!now().fresh) return Outcome::section_end;
        const std::string_view title = trimmed(cursor_.rest.substr(0, cursor_.rest.find_first_of("(;")));
        if (running_.size() == 1) name_ = title;
        if (!take_program_number(cursor_.rest)) cursor_.rest.remove_prefix(title.size());
        now().fresh = false;
    }
    if (first == '*' || first == '/') {
        now().fresh = now().fresh && first == '*';
        if (first == '*')
            findings_.ignored(cursor_.spot(), "*");
        else
            findings_.count("NC0016", Severity::warning, cursor_.spot(), "/", "block skipped, as block delete asks for",
                            "take the slash away if it shall be read");
        now().at = now().source->line_behind(now().at);
        return Outcome::nothing;
    }
    if (cursor_.front() == '\0') {
        now().at = now().source->line_behind(now().at);
        return Outcome::nothing;
    }
    now().fresh = false;
    if (!sequence_number()) return Outcome::refused;
    return behind_number(block);
}

bool Interpreter::sequence_number() {
    if (upper(cursor_.front()) != 'N') return true;
    const int at = cursor_.column();
    LineCursor ahead = cursor_;
    ahead.take(ahead.front());
    ahead.rest = skip_blanks(ahead.rest);
    std::size_t digits = 0;
    while (digits < ahead.rest.size() && is_digit(ahead.rest[digits])) ++digits;
    if (digits == 0) return refuse("NC0802", cursor_.spot(at), "N needs a whole number", cursor_.rest.substr(0, 12));
    ahead.rest.remove_prefix(digits);
    cursor_ = ahead;
    return true;
}

/// A statement or words.
Interpreter::Outcome Interpreter::behind_number(Block& block) {
    while (cursor_.front() == '(')
        if (!comment()) return Outcome::refused;
    if (cursor_.front() == '#') return assignments();
    const UpperWord letters(cursor_.rest);
    const std::string_view text = letters.text();
    if (text.size() < 2) return words(block);
    if (text == "IF") return condition(block);
    if (text == "GOTO") return go_to();
    if (text == "WHILE" || text == "DO") return loop();
    if (text == "END") return loop_end();
    for (const std::string_view output : {"POPEN", "PCLOS", "DPRNT", "BPRNT", "SETVN"})
        if (text.starts_with(output)) {
            findings_.ignored(cursor_.spot(), output);
            now().at = now().source->line_behind(now().at);
            return Outcome::nothing;
        }
    return words(block);
}

// --------------------------------------------------------------------------------------------------------------- words

Interpreter::Outcome Interpreter::words(Block& block) {
    block.words.clear();
    block.line = cursor_.number;
    block.file = cursor_.file;
    for (char c = cursor_.front(); c != '\0' && c != ';'; c = cursor_.front()) {
        if (c == '/') {
            findings_.count("NC0016", Severity::warning, cursor_.spot(), "/", "block skipped, as block delete asks for",
                            "take the slash away if it shall be read");
            cursor_.rest = {};
            break;
        }
        if (c == '(' ? !comment() : !word(block)) return Outcome::refused;
    }
    go_behind_line();
    if (block.words.empty()) return Outcome::nothing;
    if (!find_call(block)) return Outcome::refused;
    return block.words.empty() ? Outcome::nothing : Outcome::block;
}

/// Comments may stand within each other.
bool Interpreter::comment() {
    const std::string_view rest = cursor_.rest;
    int depth = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        depth += rest[i] == '(' ? 1 : rest[i] == ')' ? -1 : 0;
        if (depth != 0) continue;
        cursor_.rest.remove_prefix(i + 1);
        return true;
    }
    const std::size_t end = rest.rfind(')');  // one that is opened twice and closed once
    if (end == rest.npos)
        return refuse("NC0203", cursor_.spot(), "a comment without its end", rest.substr(0, 20), "close it with )");
    cursor_.rest.remove_prefix(end + 1);
    return true;
}

bool Interpreter::word(Block& block) {
    const std::string_view written = cursor_.rest;
    Word word{.letter = upper(cursor_.front()), .column = cursor_.column()};
    if (word.letter == ',')
        return refuse("NC0821", cursor_.spot(), "corners between blocks (,C ,R) are not supported",
                      written.substr(0, 8), "post the rounded or broken corner itself");
    if (!is_letter(word.letter)) return refuse("NC0202", cursor_.spot(), "not expected here", written.substr(0, 1));
    if (UpperWord(written).text().size() > 1)
        return refuse("NC0204", cursor_.spot(), "unknown word: it might change motion", UpperWord(written).text());
    cursor_.rest.remove_prefix(1);
    cursor_.rest = skip_blanks(cursor_.rest);
    bool vacant = false;
    if (!skip_blanks(cursor_.rest).starts_with('=') && !number(word, vacant)) return false;
    if (skip_blanks(cursor_.rest).starts_with('='))
        return refuse("NC0801", cursor_.spot(word.column), "words of MillPlus (B5=) are not read", written.substr(0, 8),
                      "post the program for FANUC, or as CL data");
    if (!vacant) block.words.push_back(word);
    return true;
}

bool Interpreter::number(Word& word, bool& vacant) {
    std::string_view after = cursor_.rest;
    if (const auto value = take_number(after)) {
        word.value = *value;
        word.has_point = cursor_.rest.substr(0, cursor_.rest.size() - after.size()).contains('.');
        cursor_.rest = after;
        return true;
    }
    if (!ParameterExpressions::starts_here(cursor_))
        return refuse("NC0201", cursor_.spot(word.column), "no finite number behind the letter",
                      std::string_view(&word.letter, 1));
    ParameterValue value;
    expressions_.set_rounding_step(least_increment_);
    const bool good = expressions_.value(cursor_, value);
    expressions_.set_rounding_step(1);
    vacant = !value;
    word.value = value.value_or(0);
    word.has_point = true;
    return good;
}

// ---------------------------------------------------------------------------------------------------------- statements

/// Nothing but comments may follow; the next block is what stands behind `;`, or the next line.
bool Interpreter::statement_ends() {
    while (cursor_.front() == '(')
        if (!comment()) return false;
    const char c = cursor_.front();
    if (c != '\0' && c != ';')
        return refuse("NC0803", cursor_.spot(), "not expected behind a statement", cursor_.rest.substr(0, 12));
    go_behind_line();
    return true;
}

bool Interpreter::take_word(std::string_view word) {
    cursor_.front();
    if (cursor_.rest.size() < word.size() || !reads(cursor_.rest.substr(0, word.size()), word)) return false;
    cursor_.rest.remove_prefix(word.size());
    return true;
}

Interpreter::Outcome Interpreter::assignments() {
    while (cursor_.front() == '#') {
        const Spot at = cursor_.spot();
        ParameterReference variable;
        ParameterValue value;
        if (!expressions_.reference(cursor_, variable)) return Outcome::refused;
        if (!cursor_.take('='))
            return refused("NC0803", cursor_.spot(), "a variable without = is no statement",
                           cursor_.rest.substr(0, 12));
        if (!expressions_.expression(cursor_, value) || !assign(variable, value, at)) return Outcome::refused;
    }
    return statement_ends() ? Outcome::nothing : Outcome::refused;
}

bool Interpreter::assign(const ParameterReference& variable, const ParameterValue& value, const Spot& at) {
    const std::string written = fmt::format("#{}", variable.number);
    if (variable.number == 0) return refuse("NC0811", at, "#0 is always vacant: it cannot be set", written);
    if (variable.number < first_of_control || variable.number > last_of_control) {
        parameters_.set(variable, value);
        return true;
    }
    if (variable.number == alarm_variable)
        return refuse("NC0812", at, "the program itself stops here with an alarm",
                      fmt::format("#3000={}", value.value_or(0)), "it found something that it takes for wrong");
    if (variable.number != message_variable && !is_harmless(variable.number))
        return refuse("NC0811", at, "a variable of the control is set: it might change motion", written,
                      "offsets and tools are of the setup file");
    findings_.ignored(at, written);
    return true;
}

bool Interpreter::truth(bool& holds) {
    ParameterValue value;
    if (!expressions_.bracketed(cursor_, value)) return false;
    holds = value.value_or(0) != 0;
    return true;
}

/// IF [condition] GOTO n, IF [condition] THEN statement.
Interpreter::Outcome Interpreter::condition(Block& block) {
    bool holds = false;
    take_word("IF");
    if (!truth(holds)) return Outcome::refused;
    if (take_word("THEN")) {
        if (holds) return behind_number(block);
    } else if (UpperWord(skip_blanks(cursor_.rest)).text() == "GOTO") {
        if (holds) return go_to();
    } else {
        return refused("NC0803", cursor_.spot(), "IF needs GOTO or THEN behind its condition",
                       cursor_.rest.substr(0, 12));
    }
    now().at = now().source->line_behind(now().at);
    return Outcome::nothing;
}

Interpreter::Outcome Interpreter::go_to() {
    take_word("GOTO");
    const Spot at = cursor_.spot();
    ParameterValue value;
    if (!expressions_.value(cursor_, value)) return Outcome::refused;
    if (!value || !is_whole_from(*value, 0, largest_label))
        return refused("NC0804", at, "GOTO needs a sequence number", fmt::format("{}", value.value_or(0)));
    if (!statement_ends() || !jump(static_cast<int>(*value), at)) return Outcome::refused;
    return Outcome::nothing;
}

/// To the next block with the number, else from the program's start on, as a control looks for it.
bool Interpreter::jump(int number, const Spot& at) {
    Running& running = now();
    const auto& labels = running.source->labels(running.section, number);
    if (labels.empty())
        return refuse("NC0804", at, "no block of this program has the sequence number", fmt::format("N{}", number));
    const auto behind =
        std::ranges::find_if(labels, [&](const Place& place) { return place.offset >= running.at.offset; });
    running.at = behind != labels.end() ? *behind : labels.front();
    return true;
}

bool Interpreter::loop_number(int& number) {
    const Spot at = cursor_.spot();
    ParameterValue value;
    if (!expressions_.value(cursor_, value)) return false;
    if (!value || !is_whole_from(*value, 1, 99))
        return refuse("NC0805", at, "DO and END need a number, the same for both",
                      fmt::format("{}", value.value_or(0)));
    number = static_cast<int>(*value);
    return true;
}

/// WHILE [condition] DO n; DO n alone goes on until a jump leaves it.
Interpreter::Outcome Interpreter::loop() {
    bool holds = true;
    int number = 0;
    const Place begin = now().at;
    const Spot at = cursor_.spot();
    if (take_word("WHILE") && !truth(holds)) return Outcome::refused;
    if (!take_word("DO")) return refused("NC0805", cursor_.spot(), "WHILE needs DO behind its condition");
    if (!loop_number(number) || !statement_ends()) return Outcome::refused;
    auto& loops = now().loops;
    const auto again = std::ranges::find(loops, number, &Loop::number);
    loops.erase(again, loops.end());
    if (holds) {
        loops.push_back({number, begin});
        return Outcome::nothing;
    }
    if (leave_loop(number)) return Outcome::nothing;
    if (repeated_lines_ > limits_.lines) return Outcome::refused;
    return refused("NC0805", at, fmt::format("no END{} follows", number));
}

/// Goes behind the END of a number.
bool Interpreter::leave_loop(int number) {
    Running& running = now();
    const std::size_t end = running.source->end_of(running.section);
    while (running.at.offset < end) {
        begin_line();
        if (running.at.offset < running.furthest && !count_line()) return false;
        running.at = running.source->line_behind(running.at);
        if (upper(cursor_.front()) == 'N') {
            cursor_.rest.remove_prefix(1);
            while (is_digit(cursor_.front())) cursor_.rest.remove_prefix(1);
        }
        if (!take_word("END")) continue;
        std::string_view digits = skip_blanks(cursor_.rest);
        if (const auto value = take_number(digits); value && *value == number) return true;
    }
    return false;
}

Interpreter::Outcome Interpreter::loop_end() {
    int number = 0;
    const Spot at = cursor_.spot();
    take_word("END");
    if (!loop_number(number) || !statement_ends()) return Outcome::refused;
    auto& loops = now().loops;
    const auto begun = std::ranges::find(loops, number, &Loop::number);
    if (begun == loops.end())
        return refused("NC0805", at, fmt::format("END{} without its DO{} before it", number, number));
    now().at = begun->begin;
    loops.erase(begun, loops.end());
    return Outcome::nothing;
}

}  // namespace trunnion::nc::fanuc
