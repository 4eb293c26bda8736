#include "detail/apt_statement.hpp"

namespace trunnion::nc {

namespace {

/// Statements whose text is for people and is not scanned.
constexpr std::string_view text_statements[] = {"PARTNO", "REMARK", "PPRINT"};

std::string_view first_word(std::string_view line) {
    std::size_t length = 0;
    while (length < line.size() && (is_letter(line[length]) || is_digit(line[length]))) ++length;
    return line.substr(0, length);
}

}  // namespace

StatementScanner::Step StatementScanner::next() {
    while (lines_.next(line_)) {
        const std::string_view text = trimmed(line_);
        if (text.empty() || is_comment(text)) continue;
        segments_.clear();
        segments_.push_back({0, {lines_.number(), 1 + static_cast<int>(text.data() - line_.data())}});
        if (take_text_statement(text)) return Step::statement;
        const std::size_t dollar = text.find('$');
        body_ = trimmed(text.substr(0, dollar));
        const bool continued = dollar != text.npos && !text.substr(dollar).starts_with("$$");
        if (continued)
            if (const Step step = join(body_); step != Step::statement) return step;
        split();
        return Step::statement;
    }
    return Step::end;
}

/// A comment line; a listing in it may go on, `, $`, with lines that start with a number.
bool StatementScanner::is_comment(std::string_view text) {
    const bool listed = listing_ && starts_number(text.front());
    if (!listed && !text.starts_with("$$")) return listing_ = false;
    listing_ = text.size() > 2 && text.ends_with('$') && trimmed(text.substr(0, text.size() - 1)).ends_with(',');
    return true;
}

bool StatementScanner::take_text_statement(std::string_view line) {
    const std::string_view word = first_word(line);
    for (const std::string_view known : text_statements) {
        if (!reads(word, known)) continue;
        body_ = line;
        major_ = word;
        arguments_ = trimmed(line.substr(word.size()));
        if (arguments_.starts_with('/')) arguments_ = trimmed(arguments_.substr(1));
        return true;
    }
    return false;
}

StatementScanner::Step StatementScanner::join(std::string_view first) {
    joined_.assign(first);
    for (bool continued = true; continued;) {
        if (!lines_.next(line_)) {
            body_ = joined_;
            split();
            return Step::truncated;
        }
        continued = append(line_);
    }
    body_ = joined_;
    return Step::statement;
}

/// One more line of the statement; whether another one follows.
bool StatementScanner::append(std::string_view line) {
    const std::size_t dollar = line.find('$');
    const std::string_view text = trimmed(line.substr(0, dollar));
    const bool comment = dollar != line.npos && line.substr(dollar).starts_with("$$");
    joined_ += ' ';
    segments_.push_back({joined_.size(), {lines_.number(), 1 + static_cast<int>(text.data() - line.data())}});
    joined_ += text;
    return comment ? text.empty() : dollar != line.npos;
}

void StatementScanner::split() {
    if (!body_.empty() && starts_number(body_.front())) {
        major_ = {};
        arguments_ = body_;
        return;
    }
    const std::size_t slash = body_.find('/');
    major_ = trimmed(body_.substr(0, slash));
    arguments_ = slash == body_.npos ? body_.substr(body_.size()) : trimmed(body_.substr(slash + 1));
}

Spot StatementScanner::spot(std::string_view part) const {
    const auto offset = static_cast<std::size_t>(part.data() - body_.data());
    std::size_t at = segments_.size() - 1;
    while (at > 0 && segments_[at].offset > offset) --at;
    return {segments_[at].spot.line, segments_[at].spot.column + static_cast<int>(offset - segments_[at].offset)};
}

}  // namespace trunnion::nc
