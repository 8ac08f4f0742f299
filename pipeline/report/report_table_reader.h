#pragma once

#include "pipeline/config.h"
#include "pipeline/report/report_expression.h"
#include "pipeline/toml_file.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace slim {

/// Gives a table's values to their members; anything else in it is an error with the nearest name.
class TableReader {
public:
    TableReader(const TomlTable& table, const std::filesystem::path& file)
        : table_(table), file_(file) {}

    std::string place(int line) const {
        return line > 0 ? fmt::format("{}:{}", file_.string(), line) : file_.string() + ", --set";
    }
    std::string place() const { return place(table_.line); }

    void text(const std::string& key, std::string& member) {
        on(key, [&member](const TomlValue& v) { member = v.items.at(0); });
    }
    void flag(const std::string& key, bool& member) {
        on(key, [this, &member](const TomlValue& v) {
            if (v.kind != Field::Kind::boolean) wrong(v, "true or false");
            member = v.items.at(0) == "true";
        });
    }
    void whole(const std::string& key, int& member) {
        on(key, [this, &member](const TomlValue& v) { member = integer(v, v.items.at(0)); });
    }
    void wholes(const std::string& key, std::vector<int>& member) {
        on_list(key, [this, &member](const TomlValue& v) {
            member.clear();
            for (const std::string& item : v.items) member.push_back(integer(v, item));
        });
    }
    void texts(const std::string& key, std::vector<std::string>& member) {
        on_list(key, [&member](const TomlValue& v) { member = v.items; });
    }
    void formula(const std::string& key, Expression& member) {
        on(key, [this, key, &member](const TomlValue& v) {
            member = Expression(v.items.at(0), place(v.line) + ": " + key);
        });
    }
    /// A table [key] or every table of [[key]].
    void tables(const std::string& key, const std::function<void(const TomlTable&)>& take) {
        table_readers_[key] = take;
    }

    /// Reads everything; call when all members are known.
    void read() const {
        for (const TomlValue& value : table_.values) {
            const auto found = readers_.find(value.key);
            if (found == readers_.end()) unknown("key", value.key, value.line, names(readers_));
            if (value.items.empty() && !lists_.contains(value.key)) wrong(value, "a value");
            if (value.is_list && !lists_.contains(value.key)) wrong(value, "one value, not a list");
            found->second(value);
        }
        for (const TomlTable& table : table_.tables) {
            const auto found = table_readers_.find(table.name);
            if (found == table_readers_.end())
                unknown("table", table.name, table.line, names(table_readers_));
            found->second(table);
        }
    }

private:
    using Reader = std::function<void(const TomlValue&)>;
    void on(const std::string& key, Reader reader) { readers_[key] = std::move(reader); }
    void on_list(const std::string& key, Reader reader) {
        lists_.insert(key);
        on(key, std::move(reader));
    }
    [[noreturn]] void wrong(const TomlValue& value, const char* expected) const {
        throw ConfigError(fmt::format("{}: {}: expected {}, found '{}'", place(value.line),
                                      value.key, expected, fmt::join(value.items, ", ")));
    }
    int integer(const TomlValue& value, const std::string& item) const {
        int number = 0;
        const auto [end, error] = std::from_chars(item.data(), item.data() + item.size(), number);
        if (error != std::errc{} || *end != '\0' || number < 0)
            wrong(value, "a whole number, 0 or more");
        return number;
    }
    [[noreturn]] void unknown(const char* what, const std::string& name, int line,
                              const std::vector<std::string>& known) const {
        throw ConfigError(
            fmt::format("{}: unknown {} '{}'{}", place(line), what, name, suggestion(name, known)));
    }
    template <class Map>
    static std::vector<std::string> names(const Map& map) {
        std::vector<std::string> out;
        for (const auto& [name, reader] : map) out.push_back(name);
        return out;
    }

    const TomlTable& table_;
    std::filesystem::path file_;
    std::map<std::string, Reader> readers_;
    std::set<std::string> lists_;
    std::map<std::string, std::function<void(const TomlTable&)>> table_readers_;
};

}  // namespace slim
