#include "pipeline/render/word_list.h"

#include "pipeline/config.h"
#include "pipeline/render/render_view.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace slim {

std::vector<std::string> split_descriptions(const std::string& text) {
    std::vector<std::string> out;
    std::stringstream in(text);
    for (std::string part; std::getline(in, part, ';');) {
        const std::size_t first = part.find_first_not_of(" \t"),
                          last = part.find_last_not_of(" \t");
        if (first != std::string::npos) out.push_back(part.substr(first, last - first + 1));
    }
    return out;
}

WordList::WordList(std::string where, const std::string& text, bool has_kind)
    : where_(std::move(where)), text_(text) {
    std::stringstream in(text);
    if (has_kind) in >> kind_;
    for (std::string word; in >> word;) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos || equals == 0)
            fail({.expected = "key=value", .found = "'" + word + "'"});
        if (has(word.substr(0, equals)))
            fail(fmt::format("{} is given twice", word.substr(0, equals)));
        words_.emplace_back(word.substr(0, equals), word.substr(equals + 1));
    }
}

void WordList::fail(Fault fault) const {
    fault.key = where_;
    fault.problem =
        fmt::format(" \"{}\"{}{}", text_, fault.problem.empty() ? "" : ": ", fault.problem);
    throw ConfigError(fault);
}

bool WordList::has(std::string_view key) const {
    return std::any_of(words_.begin(), words_.end(),
                       [&](const auto& word) { return word.first == key; });
}

std::string WordList::text(const char* key, const std::string& otherwise) {
    known_.push_back(key);
    const auto it = std::find_if(words_.begin(), words_.end(),
                                 [&](const auto& word) { return word.first == key; });
    if (it == words_.end()) return otherwise;
    const std::string value = it->second;
    words_.erase(it);
    return value;
}

bool WordList::takes(const char* key, std::string_view value) {
    return std::erase_if(words_, [&](const auto& word) {
               return word.first == key && word.second == value;
           }) > 0;
}

std::vector<double> WordList::numbers(const char* key, std::size_t n,
                                      std::vector<double> otherwise) {
    const std::string value = text(key, "");
    if (value.empty()) return otherwise;
    const std::vector<double> numbers = parse_numbers(value);
    const bool finite = std::all_of(numbers.begin(), numbers.end(),
                                    [](double v) { return std::isfinite(v); });
    if (numbers.size() != n || !finite)
        fail({.problem = key,
              .expected = fmt::format("{} number{}{}", n, n == 1 ? "" : "s",
                                      n == 3   ? " x,y,z"
                                      : n == 2 ? " a,b"
                                               : ""),
              .found = "'" + value + "'"});
    return numbers;
}

double WordList::number(const char* key, double otherwise, double min, double max) {
    const double value = numbers(key, 1, {otherwise})[0];
    if (!(value >= min && value <= max))
        fail({.problem = key,
              .expected = fmt::format("a number in [{:g}, {:g}]", min, max),
              .found = fmt::format("{:g}", value)});
    return value;
}

Vec3d WordList::vector(const char* key, const Vec3d& otherwise) {
    const std::vector<double> v = numbers(key, 3, {otherwise.x, otherwise.y, otherwise.z});
    return {v[0], v[1], v[2]};
}

bool WordList::on_off(const char* key, bool otherwise) {
    const std::string value = text(key, otherwise ? "on" : "off");
    if (value == "on" || value == "true") return true;
    if (value == "off" || value == "false") return false;
    fail({.problem = key,
          .expected = "on or off",
          .found = "'" + value + "'",
          .hint = did_you_mean(value, {"on", "off"})});
}

Vec3f WordList::color(const char* key, const Vec3f& otherwise, const std::string& word) {
    const std::string value = text(key, "");
    if (value.empty()) return otherwise;
    const auto color = parse_color(value);
    if (!color)
        fail({.problem = key,
              .expected = word.empty() ? "#rrggbb" : "#rrggbb or " + word,
              .found = "'" + value + "'",
              .hint = word.empty() ? "" : did_you_mean(value, {word})});
    return *color;
}

void WordList::finish() const {
    if (words_.empty()) return;
    const std::string& key = words_.front().first;
    fail({.problem = "unknown key '" + key + "'",
          .expected = fmt::format("{}", fmt::join(known_, ", ")),
          .hint = did_you_mean(key, known_)});
}

}  // namespace slim
