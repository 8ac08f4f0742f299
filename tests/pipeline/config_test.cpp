#include "pipeline/config.h"

#include "pipeline/toml_file.h"
#include "slim/base/error.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace slim {
namespace {

namespace fs = std::filesystem;

struct SampleConfig {
    std::vector<std::string> inputs;
    std::string output;
    int degree = 2;
    double t_mdl = 0.01;
    float range = 0;
    bool legend = true;
    std::uint64_t seed = 1;
    std::string normals = "auto";
    std::vector<std::string> aov = {"shaded"};
    std::vector<double> offset;
    std::string work;

    template <class V>
    void visit(V&& field) {
        field.input("inputs", inputs, "clouds");
        field.output("output", output, "model");
        field("degree", degree, "degree", 1, 3);
        field("t_mdl", t_mdl, "threshold", 1e-12, 1e3);
        field("range", range, "range", 0, 10);
        field("legend", legend, "legend");
        field("seed", seed, "seed");
        field.choice("normals", normals, "normals", {"auto", "keep", "estimate"});
        field.choice("aov", aov, "pictures", {"shaded", "mean", "k1"});
        field("offset", offset, "offset");
        field.path("work", work, "folder");
    }
};

/// The message of the ConfigError that the call throws, "" if it throws none.
template <class Call>
std::string refusal(const Call& call) {
    try {
        call();
        return "";
    } catch (const ConfigError& error) {
        return error.what();
    }
}

fs::path write_file(const std::string& name, const std::string& text) {
    const fs::path path = fs::path(testing::TempDir()) / (std::to_string(getpid()) + "_" + name);
    std::ofstream(path) << text;
    return path;
}

TEST(Config, SetsEveryKindOfField) {
    SampleConfig config;
    const FieldList fields = fields_of(config);
    fields.find("degree")->set({"3"}, {.key = "x"});
    fields.find("t_mdl")->set({"1e-3"}, {.key = "x"});
    fields.find("range")->set({"2.5"}, {.key = "x"});
    fields.find("legend")->set({"false"}, {.key = "x"});
    fields.find("seed")->set({"18446744073709551615"}, {.key = "x"});
    fields.find("aov")->set({"mean", "k1"}, {.key = "x"});
    fields.find("offset")->set({"-1", "2.5", "1e6"}, {.key = "x"});
    EXPECT_EQ(config.degree, 3);
    EXPECT_EQ(config.t_mdl, 1e-3);
    EXPECT_EQ(config.range, 2.5f);
    EXPECT_FALSE(config.legend);
    EXPECT_EQ(config.seed, 18446744073709551615ull);
    EXPECT_EQ(config.aov, (std::vector<std::string>{"mean", "k1"}));
    EXPECT_EQ(config.offset, (std::vector<double>{-1, 2.5, 1e6}));
}

TEST(Config, AcceptsAWholeNumberWithAnExponent) {
    SampleConfig config;
    fields_of(config).find("seed")->set({"5e5"}, {.key = "x"});
    EXPECT_EQ(config.seed, 500000u);
    EXPECT_NE(refusal([&] { fields_of(config).find("seed")->set({"5e-1"}, {.key = "x"}); }), "");
    EXPECT_NE(refusal([&] { fields_of(config).find("seed")->set({"-1"}, {.key = "x"}); }), "");
}

TEST(Config, RefusesWhatIsOutOfRangeOrNoNumber) {
    SampleConfig config;
    const FieldList fields = fields_of(config);
    EXPECT_EQ(refusal([&] { fields.find("degree")->set({"4"}, {.option = "--degree"}); }),
              "--degree: expected a number in [1, 3]; found 4");
    EXPECT_EQ(refusal([&] { fields.find("degree")->set({"two"}, {.option = "--degree"}); }),
              "--degree: expected a whole number, found 'two'");
    EXPECT_NE(refusal([&] { fields.find("t_mdl")->set({"nan"}, {.key = "x"}); }), "");
    // Of any size is no number without one.
    double any = 0;
    FieldList free;
    free("any", any, "any number");
    for (const char* item : {"nan", "inf", "-inf"})
        EXPECT_EQ(refusal([&] { free.find("any")->set({item}, {.option = "--any"}); }),
                  std::string("--any: expected a finite number, found ") + item);
    free.find("any")->set({"-1e300"}, {.option = "--any"});
    EXPECT_EQ(any, -1e300);
    EXPECT_NE(refusal([&] { fields.find("legend")->set({"yes"}, {.key = "x"}); }), "");
    EXPECT_EQ(config.degree, 2);  // a refused value changes nothing
}

TEST(Config, SuggestsTheNearestChoice) {
    SampleConfig config;
    EXPECT_EQ(
        refusal([&] { fields_of(config).find("normals")->set({"kepe"}, {.option = "--normals"}); }),
        "--normals: expected one of auto, keep, estimate; found 'kepe' (did you mean 'keep'?)");
    EXPECT_NE(
        refusal([&] { fields_of(config).find("aov")->set({"shaded", "men"}, {.key = "x"}); }), "");
    EXPECT_EQ(suggestion("wholly-different", {"keep"}), "");
}

TEST(Config, SuggestsNoNameOfWhichNothingIsLeft) {
    EXPECT_EQ(did_you_mean("4", {"1", "2"}), "");
    EXPECT_EQ(did_you_mean("ab", {"on"}), "");
    EXPECT_EQ(did_you_mean("fornt", {"back", "front"}), "did you mean 'front'?");
    EXPECT_EQ(did_you_mean("Y", {"x", "y"}), "did you mean 'y'?");
}

TEST(Config, AnErrorHasItsPartsBesideItsText) {
    SampleConfig config;
    const fs::path file = write_file("parts.toml", "degree = 2\nnormals = 'kepe'\n");
    try {
        apply_config_file(file, fields_of(config));
        FAIL();
    } catch (const ConfigError& error) {
        const Fault& fault = error.fault();
        EXPECT_EQ(fault.file, file.string());
        EXPECT_EQ(fault.line, 2);
        EXPECT_EQ(fault.key, "normals");
        EXPECT_EQ(fault.found, "'kepe'");
        EXPECT_EQ(fault.hint, "did you mean 'keep'?");
        EXPECT_EQ(message_of(fault), error.what());
    }
}

TEST(Config, HashesWhatCountsAndNotThePaths) {
    SampleConfig a, b;
    b.inputs = {"elsewhere.ply"};
    b.output = "other.slim";
    b.work = "folder";
    EXPECT_EQ(canonical_config(fields_of(a)), canonical_config(fields_of(b)));
    b.seed = 2;
    EXPECT_NE(canonical_config(fields_of(a)), canonical_config(fields_of(b)));
}

TEST(Config, NamesWhatIsMissing) {
    SampleConfig config;
    EXPECT_EQ(refusal([&] { check_required(fields_of(config)); }), "missing inputs: clouds");
    FieldList fields = fields_of(config);
    config.inputs = {"a.ply"};
    EXPECT_EQ(refusal([&] { check_required(fields); }), "missing -o: model");
    config.output = "m.slim";
    EXPECT_EQ(refusal([&] { check_required(fields); }), "");
}

TEST(TomlFile, ReadsBackWhatPrintConfigWrites) {
    SampleConfig config;
    config.inputs = {"/a b/\"quoted\"\\.ply", "/c.ply"};
    config.output = "/m.slim";
    config.t_mdl = 0.1 + 0.2;
    config.range = 7;
    config.legend = false;
    config.offset = {403000.25, -1, 1e300};
    config.aov = {"k1"};
    const std::string text = print_config(fields_of(config));
    SampleConfig back;
    apply_config_file(write_file("round_trip.toml", text), fields_of(back));
    EXPECT_EQ(print_config(fields_of(back)), text);
    EXPECT_EQ(back.inputs, config.inputs);
    EXPECT_EQ(back.t_mdl, config.t_mdl);
}

TEST(TomlFile, ReadsTheDefaultsThatPrintConfigWrites) {
    SampleConfig config;
    const std::string text = print_config(fields_of(config));
    EXPECT_NE(text.find("# output = "), std::string::npos);  // required: no value to read back
    SampleConfig back;
    apply_config_file(write_file("defaults.toml", text), fields_of(back));
    EXPECT_EQ(print_config(fields_of(back)), text);
}

struct ChoiceConfig {
    std::string degree = "2";
    template <class Visitor>
    void visit(Visitor&& field) {
        field.choice("degree", degree, "degree", {"1", "2", "auto"});
    }
};

TEST(TomlFile, AChoiceMayBeANumberWithoutQuotes) {
    ChoiceConfig config;
    FieldList fields;
    config.visit(fields);
    EXPECT_NE(print_config(fields).find("degree = 2\n"), std::string::npos);
    for (const auto& [text, value] : {std::pair{"degree = 1", "1"}, std::pair{"degree = '2'", "2"},
                                      std::pair{"degree = 'auto'", "auto"}}) {
        apply_config_file(write_file("choice.toml", text), fields);
        EXPECT_EQ(config.degree, value);
    }
    EXPECT_NE(print_config(fields).find("degree = \"auto\"\n"), std::string::npos);
    for (const char* text :
         {"degree = 3", "degree = 1.5", "degree = true", "degree = [1]", "degree = 'atuo'"})
        EXPECT_THROW(apply_config_file(write_file("choice.toml", text), fields), ConfigError)
            << text;
    const std::string one_letter =
        refusal([&] { fields.find("degree")->set({"4"}, {.option = "--degree"}); });
    EXPECT_EQ(one_letter, "--degree: expected one of 1, 2, auto; found '4'");
}

TEST(TomlFile, ResolvesPathsAgainstTheFile) {
    const fs::path file = write_file("paths.toml", "inputs = ['sub/a.ply']\nwork = '../w'\n");
    SampleConfig config;
    apply_config_file(file, fields_of(config));
    EXPECT_EQ(config.inputs[0], (file.parent_path() / "sub/a.ply").lexically_normal().string());
    EXPECT_EQ(config.work, (file.parent_path() / "../w").lexically_normal().string());
}

TEST(TomlFile, NamesLineAndNearestKeyOfAnUnknownOne) {
    const fs::path file = write_file("unknown.toml", "degree = 2\n\ndegre = 3\n");
    SampleConfig config;
    EXPECT_EQ(refusal([&] { apply_config_file(file, fields_of(config)); }),
              file.string() + ":3: unknown key 'degre' (did you mean 'degree'?)");
}

TEST(TomlFile, NamesAllKeysWhereNoneIsNearAnUnknownOne) {
    const fs::path file = write_file("far.toml", "qqqqqqqqqq = 3\n");
    SampleConfig config;
    const std::string said = refusal([&] { apply_config_file(file, fields_of(config)); });
    const std::string start = file.string() + ":1: unknown key 'qqqqqqqqqq': expected one of ";
    EXPECT_EQ(said, start + fmt::format("{}", fmt::join(keys_of(fields_of(config)), ", ")));
}

TEST(TomlFile, AListMayBeWrittenAsOnACommandLine) {
    const auto read = [](const std::string& text) {
        SampleConfig config;
        apply_config_file(write_file("lists.toml", text), fields_of(config));
        return config;
    };
    EXPECT_EQ(read("aov = 'mean,k1'").aov, (std::vector<std::string>{"mean", "k1"}));
    EXPECT_EQ(read("aov = 'k1'").aov, (std::vector<std::string>{"k1"}));
    EXPECT_EQ(read("aov = ''").aov, (std::vector<std::string>{}));
    EXPECT_EQ(read("offset = '1,-2.5,3e2'").offset, (std::vector<double>{1, -2.5, 300}));
    EXPECT_EQ(read("offset = 4").offset, (std::vector<double>{4}));
    const SampleConfig clouds = read("inputs = 'a,b.ply'");  // a word is one file
    ASSERT_EQ(clouds.inputs.size(), 1u);
    EXPECT_TRUE(clouds.inputs[0].ends_with("/a,b.ply")) << clouds.inputs[0];
    SampleConfig config;
    const fs::path file = write_file("lists.toml", "degree = 2\naov = 'mean,k2'\n");
    EXPECT_EQ(refusal([&] { apply_config_file(file, fields_of(config)); }),
              file.string() + ":2: aov: expected one of shaded, mean, k1; found 'k2' (did you mean "
                              "'k1'?)");
}

TEST(TomlFile, SaysWhatIsNotTomlInItsOwnWords) {
    const auto said = [](const std::string& text) {
        SampleConfig config;
        const fs::path file = write_file("broken.toml", text);
        const std::string what = refusal([&] { apply_config_file(file, fields_of(config)); });
        EXPECT_TRUE(what.starts_with(file.string())) << what;
        return what.substr(std::min(what.size(), file.string().size()));
    };
    EXPECT_EQ(said("degree = 1\n\ndegree = 2\n"), ":3: degree is there already, in line 1");
    EXPECT_EQ(said("degree = '''\na\n''' # '\ndegree = 2\n"),
              ":4: degree is there already, in line 1");
    const std::string bare = said("degree = 1\naov = shaded\n");
    EXPECT_TRUE(bare.starts_with(":2: not TOML, column ")) << bare;
    EXPECT_NE(bare.find("found 'aov = shaded'"), std::string::npos) << bare;
    const std::string open = said("degree = [1,\n");
    EXPECT_NE(open.find("not TOML"), std::string::npos) << open;
    EXPECT_EQ((bare + open).find("rror while parsing"), std::string::npos);
}

TEST(TomlFile, WhatStandsWithinAValueIsNoKeyThatIsThereAlready) {
    const auto said = [](const std::string& text) {
        const fs::path file = write_file("within.toml", text);
        return refusal([&] { read_toml(file); }).substr(file.string().size());
    };
    const char* values[] = {
        "a = \"\"\"\nb = 1\n\\\"\"\"\\\nb = 2\n\"\"\"\n",  // with quotes and a line's end escaped
        "a = '''\nb = 1\n'''\n",
        "a = [\n'b = 1', # ]\n\"]\",\n]\n",
        "[a]\nb = 1\n[[c]] # '\n",
        "a = '#' # \"\"\"\n[d]\nb = 1\n[c]\n",
    };
    for (const char* value : values) {
        SCOPED_TRACE(value);
        const std::string what = said(std::string(value) + "b = open\n");
        EXPECT_EQ(what.find("already"), std::string::npos) << what;
        EXPECT_NE(what.find("found 'b = open'"), std::string::npos) << what;
        const auto lines = static_cast<int>(std::count(value, value + std::strlen(value), '\n'));
        const std::string twice = said(std::string(value) + "b = 1\nb = 2\n");
        EXPECT_EQ(twice, fmt::format(":{}: b is there already, in line {}", lines + 2, lines + 1));
    }
}

TEST(TomlFile, RefusesWrongTypes) {
    const char* texts[] = {
        "degree = 2.5",    "degree = '2'",          "degree = [2]",   "t_mdl = true",
        "legend = 1",      "aov = [1]",      "normals = 1",
        "degree = ",       "seed = 1979-05-27",     "offset = [[1]]", "[fit]\ndegree = 1",
        "aov = ['k1', 2]", "degree = 1\ndegree = 2"};
    for (const char* text : texts) {
        SCOPED_TRACE(text);
        const fs::path file = write_file("wrong.toml", text);
        SampleConfig config;
        EXPECT_TRUE(refusal([&] { apply_config_file(file, fields_of(config)); })
                        .starts_with(file.string() + ":"));
    }
}

TEST(TomlFile, MissingFileIsAnInputError) {
    SampleConfig config;
    EXPECT_THROW(apply_config_file("/no/such.toml", fields_of(config)), ConfigError);
    EXPECT_THROW(apply_config_file(testing::TempDir(), fields_of(config)), ConfigError);
}

TEST(TomlFile, KeepsTheOrderOfTablesInTheFile) {
    const fs::path file = write_file(
        "tables.toml", "[[view]]\nname = 'z'\n[output]\ndir = 'o'\n[[view]]\nname = 'a'\n");
    const TomlTable root = read_toml(file);
    ASSERT_EQ(root.tables.size(), 3u);
    EXPECT_EQ(root.tables[0].values[0].items[0], "z");
    EXPECT_EQ(root.tables[1].name, "output");
    EXPECT_EQ(root.tables[2].values[0].items[0], "a");
    EXPECT_EQ(root.tables[2].values[0].line, 6);
}

}  // namespace
}  // namespace slim
