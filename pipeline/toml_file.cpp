#include "pipeline/toml_file.h"

#include "slim/base/error.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>

namespace slim {
namespace {

namespace fs = std::filesystem;

int line_of(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

/// One scalar's kind and text; false for what our files do not use (dates, tables, arrays).
bool scalar(const toml::node& node, Field::Kind& kind, std::string& text) {
    if (const auto* boolean = node.as_boolean()) {
        kind = Field::Kind::boolean;
        text = boolean->get() ? "true" : "false";
    } else if (const auto* integer = node.as_integer()) {
        kind = Field::Kind::integer;
        text = fmt::format("{}", integer->get());
    } else if (const auto* real = node.as_floating_point()) {
        kind = Field::Kind::real;
        text = fmt::format("{}", real->get());
    } else if (const auto* string = node.as_string()) {
        kind = Field::Kind::text;
        text = string->get();
    } else {
        return false;
    }
    return true;
}

[[noreturn]] void unreadable(const fs::path& file, const TomlValue& value) {
    Fault fault = toml_fault(file, value.line, value.key);
    fault.expected = "a string, a number, true, false or a plain array of one kind of them";
    throw ConfigError(fault);
}

/// Whole numbers among real ones make a real array; anything else must be of one kind.
Field::Kind common_kind(Field::Kind a, Field::Kind b, const fs::path& file,
                        const TomlValue& value) {
    if (a == b) return a;
    const auto number = [](Field::Kind k) {
        return k == Field::Kind::integer || k == Field::Kind::real;
    };
    if (!number(a) || !number(b)) unreadable(file, value);
    return Field::Kind::real;
}

TomlValue read_value(const std::string& key, const toml::node& node, const fs::path& file) {
    TomlValue value{key, Field::Kind::text, node.is_array(), {}, line_of(node)};
    std::string text;
    if (!value.is_list) {
        if (!scalar(node, value.kind, text)) unreadable(file, value);
        value.items = {text};
        return value;
    }
    for (const toml::node& item : *node.as_array()) {
        Field::Kind kind{};
        if (!scalar(item, kind, text)) unreadable(file, value);
        value.kind = value.items.empty() ? kind : common_kind(value.kind, kind, file, value);
        value.items.push_back(text);
    }
    return value;
}

TomlTable read_table(const std::string& name, const toml::table& in, const fs::path& file) {
    TomlTable out{name, line_of(in), {}, {}};
    for (const auto& [key_view, node] : in) {
        const std::string key(key_view);
        const toml::array* array = node.as_array();
        if (const toml::table* table = node.as_table()) {
            out.tables.push_back(read_table(key, *table, file));
        } else if (array && !array->empty() && array->is_array_of_tables()) {
            for (const toml::node& item : *array)
                out.tables.push_back(read_table(key, *item.as_table(), file));
        } else {
            out.values.push_back(read_value(key, node, file));
        }
    }
    // toml++ sorts by name; the order in the file is what a reader expects errors and views in.
    const auto by_line = [](const auto& a, const auto& b) { return a.line < b.line; };
    std::stable_sort(out.values.begin(), out.values.end(), by_line);
    std::stable_sort(out.tables.begin(), out.tables.end(), by_line);
    return out;
}

const char* kind_name(Field::Kind kind) {
    switch (kind) {
        case Field::Kind::boolean: return "true or false";
        case Field::Kind::integer: return "a whole number";
        case Field::Kind::real: return "a number";
        default: return "a string";
    }
}

/// A word may be a number (contours: "auto" or a distance) and then stands without quotes.
bool is_bare_number(const TomlValue& value, const Field& field) {
    return field.kind() == Field::Kind::text && !field.is_path() &&
           (value.kind == Field::Kind::integer || value.kind == Field::Kind::real);
}

void check_type(const TomlValue& value, const Field& field, Fault where) {
    const bool same = value.kind == field.kind() || value.items.empty() ||
                      (field.kind() == Field::Kind::real && value.kind == Field::Kind::integer) ||
                      (!field.choices.empty() && value.kind == Field::Kind::integer) ||
                      is_bare_number(value, field);
    const bool one_text = field.is_list() && !value.is_list && value.kind == Field::Kind::text;
    if (one_text || (same && (!value.is_list || field.is_list()))) return;
    where.expected = (field.is_list() ? "an array, each item " : "") +
                     std::string(kind_name(field.kind()));
    where.found = (value.is_list ? "an array of " : "") + std::string(kind_name(value.kind));
    throw ConfigError(where);
}

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r"),
                      last = text.find_last_not_of(" \t\r");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// The key of "key = value", "[table]" or "[[table]]", else "".
std::string name_in(const std::string& line) {
    const std::string text = trimmed(line);
    if (text.starts_with('[')) return text.substr(0, text.find_last_of(']') + 1);
    const std::size_t equals = text.find('=');
    return equals == std::string::npos || text.find('#') < equals ? ""
                                                                  : trimmed(text.substr(0, equals));
}

/// Goes through TOML that is sound up to some line, to tell what stands within values.
class ValueScan {
public:
    explicit ValueScan(std::string_view text) : text_(text) { begin_line(0); }

    /// For each line, whether it begins within a string or an array of several lines.
    std::vector<bool> lines_within() {
        for (std::size_t at = 0; at < text_.size(); ++at) {
            if (text_[at] == '\n') end_line(at);
            else if (!quote_.empty()) at += step_in_string(at);
            else if (!comment_) at += step_outside(at);
        }
        return std::move(within_);
    }

private:
    void begin_line(std::size_t at) {
        within_.push_back(!quote_.empty() || depth_ > 0);
        const std::size_t first = text_.find_first_not_of(" \t", at);
        is_table_ = !within_.back() && first < text_.size() && text_[first] == '[';
    }
    void end_line(std::size_t at) {
        comment_ = false;
        if (quote_.size() == 1) quote_ = {};
        begin_line(at + 1);
    }
    /// How many characters beyond this one are done with it.
    std::size_t step_in_string(std::size_t at) {
        if (text_.substr(at).starts_with(quote_)) {
            const std::size_t length = quote_.size();
            quote_ = {};
            return length - 1;
        }
        const bool escapes = quote_[0] == '"' && text_[at] == '\\';
        return escapes && text_.substr(at + 1, 1) != "\n" ? 1 : 0;
    }
    std::size_t step_outside(std::size_t at) {
        const char c = text_[at];
        if (c == '"' || c == '\'') {
            const bool is_long = text_.substr(at, 3) == std::string(3, c);
            quote_ = text_.substr(at, is_long ? 3 : 1);
            return quote_.size() - 1;
        }
        comment_ = c == '#';
        if (!is_table_) depth_ += (c == '[' || c == '{') - (c == ']' || c == '}');
        return 0;
    }

    std::string_view text_;
    std::string_view quote_;  ///< that ends the string; empty: in none
    int depth_ = 0;           ///< of brackets
    bool comment_ = false, is_table_ = false;
    std::vector<bool> within_;
};

/// The keys and tables that a text's lines begin, "" of lines that go on with a value.
std::vector<std::string> names_in(const std::string& text, const std::vector<std::string>& lines) {
    const std::vector<bool> within = ValueScan(text).lines_within();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < lines.size(); ++i)
        names.push_back(within[i] ? "" : name_in(lines[i]));
    return names;
}

/// The line before that has the same key in the same table, or is the same [table]; 0 without one.
std::size_t said_before(const std::vector<std::string>& names, std::size_t at) {
    const std::string& name = names[at];
    const bool is_table = name.starts_with('[');
    if (name.empty() || name.starts_with("[[")) return 0;
    for (std::size_t i = at; i-- > 0;) {
        if (names[i] == name) return i + 1;
        if (!is_table && names[i].starts_with('[')) return 0;
    }
    return 0;
}

/// What the parser does not take, in our words: its own are of its parts.
ConfigError not_toml(const fs::path& file, const std::string& text,
                     const toml::source_position& at) {
    std::vector<std::string> lines;
    std::stringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    Fault fault{.file = file.string(), .line = static_cast<int>(at.line), .problem = "not TOML"};
    const std::size_t line = at.line - 1;
    if (line >= lines.size()) {
        fault.expected = "the rest of a value", fault.found = "the end of the file";
        return ConfigError(fault);
    }
    const std::vector<std::string> names = names_in(text, lines);
    if (const std::size_t before = said_before(names, line)) {
        fault.problem = fmt::format("{} is there already, in line {}", names[line], before);
        return ConfigError(fault);
    }
    fault.problem += fmt::format(", column {}", at.column);
    fault.expected = "key = value (text in quotes), [table] or # comment";
    fault.found = "'" + trimmed(lines[line]).substr(0, 60) + "'";
    return ConfigError(fault);
}

}  // namespace

std::string toml_place(const fs::path& file, int line) {
    if (line > 0) return fmt::format("{}:{}", file.string(), line);
    return file.string() + (line == kBySet ? ", --set" : ", command line");
}

Fault toml_fault(const fs::path& file, int line, const std::string& key) {
    Fault fault{.file = file.string(), .key = key};
    if (line > 0) fault.line = line;
    else fault.said_by = line == kBySet ? "--set" : "command line";
    return fault;
}

std::vector<std::string> list_items(const Field& field, const std::string& text,
                                    const fs::path& folder) {
    std::error_code none;
    const bool is_file = field.is_path() && fs::exists(folder / text, none);
    if (is_file || (field.is_path() && field.is_word())) return {text};
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t end; (end = text.find(',', begin)) != std::string::npos; begin = end + 1)
        parts.push_back(text.substr(begin, end - begin));
    parts.push_back(text.substr(begin));
    return parts;
}

std::vector<std::string> items_for(const Field& field, const TomlValue& value,
                                   const fs::path& folder) {
    std::vector<std::string> items = value.items;
    if (field.is_list() && !value.is_list)
        items = items[0].empty() ? std::vector<std::string>{}
                                 : list_items(field, items[0], folder);
    if (!field.is_path()) return items;
    for (std::string& path : items)
        if (!path.empty()) path = (folder / path).lexically_normal().string();
    return items;
}

TomlTable read_toml(const fs::path& file) {
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    if (in) text << in.rdbuf();
    if (!in || fs::is_directory(file))
        throw ConfigError(
            {.file = file.string(),
             .problem = std::string("cannot read: ") +
                        (fs::is_directory(file) ? "is a directory" : std::strerror(errno))});
    try {
        return read_table("", toml::parse(text.view(), file.string()), file);
    } catch (const toml::parse_error& error) {
        throw not_toml(file, text.str(), error.source().begin);
    }
}

void set_value(TomlTable& root, const std::string& key_equals_value) {
    const std::size_t equals = key_equals_value.find('=');
    std::string key = key_equals_value.substr(0, equals);
    const std::string said = "--set " + key_equals_value;
    if (equals == std::string::npos || key.find('.') == std::string::npos)
        throw ConfigError(said + ": expected TABLE.KEY=VALUE, such as fit.t_mdl=0.02");
    TomlTable* table = &root;
    for (std::size_t dot; (dot = key.find('.')) != std::string::npos; key = key.substr(dot + 1)) {
        const std::string name = key.substr(0, dot);
        const auto same = [&](const TomlTable& t) { return t.name == name; };
        const auto n = std::count_if(table->tables.begin(), table->tables.end(), same);
        if (n > 1)
            throw ConfigError(
                fmt::format("{}: [[{}]] is a list: change it in the file", said, name));
        if (n == 0) table->tables.push_back({name, 0, {}, {}});
        table = &*std::find_if(table->tables.begin(), table->tables.end(), same);
    }
    const std::string text = key_equals_value.substr(equals + 1);
    TomlTable parsed;
    try {
        parsed = read_table("", toml::parse(key + " = " + text), said);
    } catch (const toml::parse_error&) {
        if (trimmed(text).starts_with('['))
            throw ConfigError({.problem = said + ": not an array",
                               .expected = "[\"a\", \"b\"], or a,b without brackets (text that "
                                           "begins with a bracket: in quotes)"});
        parsed.values = {{key, Field::Kind::text, false, {text}, 0}};
    }
    std::erase_if(table->values, [&](const TomlValue& v) { return v.key == key; });
    for (TomlValue& value : parsed.values) {
        value.line = 0;
        table->values.push_back(std::move(value));
    }
}

void apply_table(const TomlTable& table, const FieldList& fields, const fs::path& file) {
    for (const TomlValue& value : table.values) {
        const Field* field = fields.find(value.key);
        if (!field)
            throw ConfigError(unknown_key(value.key, fields)).at(toml_fault(file, value.line));
        const Fault where = toml_fault(file, value.line, value.key);
        check_type(value, *field, where);
        field->set(items_for(*field, value, file.parent_path()), where);
    }
}

std::vector<std::string> apply_config_file(const fs::path& file, const FieldList& fields) {
    const TomlTable table = read_toml(file);
    if (!table.tables.empty())
        throw ConfigError(ConfigError("unknown table [" + table.tables[0].name +
                                      "]: a stage's config holds plain keys only (a job file is "
                                      "for 'slim run')")
                              .at(toml_fault(file, table.tables[0].line)));
    apply_table(table, fields, file);
    std::vector<std::string> keys;
    for (const TomlValue& value : table.values) keys.push_back(value.key);
    return keys;
}

}  // namespace slim
