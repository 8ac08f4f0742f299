#include "pipeline/config.h"

#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace slim {
namespace {

template <class T>
struct ItemOf {
    using type = T;
    static constexpr bool list = false;
};
template <class T>
struct ItemOf<std::vector<T>> {
    using type = T;
    static constexpr bool list = true;
};

template <class T>
const char* expected_kind() {
    if constexpr (std::is_same_v<T, bool>) return "true or false";
    if constexpr (std::is_same_v<T, std::uint64_t>)
        return "a whole number from 0 to 18446744073709551615";
    if constexpr (std::is_integral_v<T>) return "a whole number";
    return "a number";
}

/// Whole numbers may be written 500000 or 5e5.
template <class T>
bool parse_number(const std::string& text, T& out) {
    const char* end = text.data() + text.size();
    const auto plain = std::from_chars(text.data(), end, out);
    if (plain.ec == std::errc() && plain.ptr == end) return true;
    if constexpr (std::is_integral_v<T>) {
        double real = 0;
        const auto exponent = std::from_chars(text.data(), end, real);
        if (exponent.ec != std::errc() || exponent.ptr != end || real != std::floor(real))
            return false;
        if (std::abs(real) > 0x1p53 || real < static_cast<double>(std::numeric_limits<T>::min()) ||
            real > static_cast<double>(std::numeric_limits<T>::max()))
            return false;
        out = static_cast<T>(real);
        return true;
    }
    return false;
}

[[noreturn]] void refuse(Fault where, std::string expected, std::string found,
                         std::string hint = {}) {
    where.expected = std::move(expected), where.found = std::move(found);
    where.hint = std::move(hint);
    throw ConfigError(where);
}

template <class T>
T parse_item(const std::string& text, const Fault& where) {
    if constexpr (std::is_same_v<T, std::string>) {
        return text;
    } else if constexpr (std::is_same_v<T, bool>) {
        if (text == "true") return true;
        if (text == "false") return false;
    } else {
        T value{};
        if (parse_number(text, value)) return value;
    }
    refuse(where, expected_kind<T>(), "'" + text + "'");
}

template <class T>
std::string item_text(const T& value) {
    if constexpr (std::is_same_v<T, bool>) return value ? "true" : "false";
    return fmt::format("{}", value);
}

std::string toml_string(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (byte < 0x20 || byte == 0x7f) {
            out += fmt::format("\\u{:04x}", byte);
        } else {
            out += c;
        }
    }
    return out + '"';
}

/// A number of TOML: a real one keeps its point, so that it reads back as real.
std::string toml_item(const std::string& text, Field::Kind kind) {
    if (kind == Field::Kind::text) return toml_string(text);
    if (kind == Field::Kind::real && text.find_first_of(".einE") == std::string::npos)
        return text + ".0";
    return text;
}

std::string join(const std::vector<std::string>& words) {
    return fmt::format("{}", fmt::join(words, ", "));
}

void check_range(const Field& field, const std::string& item, const Fault& where) {
    if (!field.choices.empty()) {
        if (std::find(field.choices.begin(), field.choices.end(), item) == field.choices.end())
            refuse(where, "one of " + join(field.choices), "'" + item + "'",
                   did_you_mean(item, field.choices));
        return;
    }
    if (field.kind() != Field::Kind::integer && field.kind() != Field::Kind::real) return;
    const double value = std::strtod(item.c_str(), nullptr);
    if (std::isfinite(value) && value >= field.min && value <= field.max) return;
    const std::string range = field.range_text();
    refuse(where,
           fmt::format("a {}number{}{}", std::isfinite(value) ? "" : "finite ",
                       range.empty() ? "" : " ", range),
           item);
}

}  // namespace

Field::Kind Field::kind() const {
    return std::visit(
        [](auto* target) {
            using T = typename ItemOf<std::remove_pointer_t<decltype(target)>>::type;
            if (std::is_same_v<T, bool>) return Kind::boolean;
            if (std::is_same_v<T, std::string>) return Kind::text;
            return std::is_integral_v<T> ? Kind::integer : Kind::real;
        },
        target_);
}

bool Field::is_list() const {
    return std::visit(
        [](auto* target) { return ItemOf<std::remove_pointer_t<decltype(target)>>::list; },
        target_);
}

bool Field::empty() const {
    const std::vector<std::string> all = items();
    return all.empty() || (!is_list() && all[0].empty());
}

std::string Field::option() const {
    std::string name = "--" + key;
    std::replace(name.begin(), name.end(), '_', '-');
    return name;
}

Fault Field::place() const {
    return {.key = key, .option = is_word() ? "" : option()};
}

void Field::set(const std::vector<std::string>& items, const Fault& where) const {
    if (!is_list() && items.size() != 1)
        refuse(where, "one value", std::to_string(items.size()));
    std::visit(
        [&](auto* target) {
            using T = std::remove_pointer_t<decltype(target)>;
            using Item = typename ItemOf<T>::type;
            T parsed{};
            for (const std::string& text : items) {
                const Item item = parse_item<Item>(text, where);
                check_range(*this, item_text(item), where);
                if constexpr (ItemOf<T>::list)
                    parsed.push_back(item);
                else
                    parsed = item;
            }
            *target = std::move(parsed);
        },
        target_);
}

std::vector<std::string> Field::items() const {
    return std::visit(
        [](auto* target) {
            std::vector<std::string> out;
            if constexpr (ItemOf<std::remove_pointer_t<decltype(target)>>::list)
                for (const auto& item : *target) out.push_back(item_text(item));
            else
                out.push_back(item_text(*target));
            return out;
        },
        target_);
}

std::string Field::toml() const {
    std::vector<std::string> all = items();
    for (std::string& item : all) {
        std::int64_t number = 0;  // a choice may be a number: it stands without quotes
        if (choices.empty() || !parse_number(item, number)) item = toml_item(item, kind());
    }
    return is_list() ? "[" + join(all) + "]" : all[0];
}

std::string Field::range_text() const {
    if (!choices.empty()) return "one of " + join(choices);
    if (std::isinf(min) && std::isinf(max)) return "";
    if (std::isinf(max)) return fmt::format(">= {}", min);
    if (std::isinf(min)) return fmt::format("<= {}", max);
    return fmt::format("in [{}, {}]", min, max);
}

const Field* FieldList::find(std::string_view key) const {
    for (const Field& field : fields_)
        if (field.key == key) return &field;
    return nullptr;
}

void check_required(const FieldList& fields) {
    for (const Field& field : fields.fields()) {
        if (!field.required || !field.empty()) continue;
        const std::string name = field.role == FieldRole::output ? "-o" : field.key;
        throw ConfigError({.problem = "missing " + name + ": " + field.help});
    }
}

std::string print_config(const FieldList& fields) {
    std::string out;
    for (const Field& field : fields.fields()) {
        const std::string range = field.range_text();
        // A required field that is still empty has no value that could be read back.
        const bool open = field.required && field.empty();
        out += fmt::format("# {}{}{}\n{}{} = {}\n", field.help, open ? ", required" : "",
                           range.empty() ? "" : " (" + range + ")", open ? "# " : "", field.key,
                           field.toml());
    }
    return out;
}

std::string canonical_config(const FieldList& fields) {
    std::string out;
    for (const Field& field : fields.fields())
        if (!field.is_path() && !field.is_part)
            out += fmt::format("{} = {}\n", field.key, field.toml());
    return out;
}

std::vector<std::string> keys_of(const FieldList& fields) {
    std::vector<std::string> keys;
    for (const Field& field : fields.fields()) keys.push_back(field.key);
    return keys;
}

Fault unknown_key(const std::string& key, const FieldList& fields) {
    const std::vector<std::string> known = keys_of(fields);
    Fault fault{.problem = "unknown key '" + key + "'", .hint = did_you_mean(key, known)};
    if (fault.hint.empty())
        fault.expected = fmt::format("{}{}", known.size() > 1 ? "one of " : "",
                                     fmt::join(known, ", "));
    return fault;
}

}  // namespace slim
