#include "pipeline/command_line.h"

#include "slim/base/error.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace slim {
namespace {

struct LineConfig {
    std::vector<std::string> inputs;
    std::string output;
    int degree = 2;
    double angle = 0;
    bool legend = true;
    bool strict = false;
    std::vector<std::string> aov = {"shaded"};
    std::string camera = "iso";
    std::vector<std::string> extra;

    template <class V>
    void visit(V&& field) {
        field.input("inputs", inputs, "clouds");
        field.output("output", output, "model");
        field("degree", degree, "degree", 1, 3);
        field("angle", angle, "angle", -90, 90);
        field("legend", legend, "legend");
        field("strict", strict, "strict");
        field("aov", aov, "pictures");
        field("camera", camera, "camera");
        field.path("extra_path", extra, "more files");
    }
};

CommonOptions parse(LineConfig& config, std::vector<std::string> words) {
    words.insert(words.begin(), "slim-line");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    return parse_command_line(static_cast<int>(argv.size()), argv.data(), fields_of(config));
}

std::string refusal(const std::vector<std::string>& words) {
    LineConfig config;
    try {
        parse(config, words);
        return "";
    } catch (const ConfigError& error) {
        return error.what();
    }
}

TEST(CommandLine, SaysWhichKeysWereGivenThoughTheyAreAsByDefault) {
    LineConfig config;
    const CommonOptions common = parse(
        config, {"x.ply", "-o", "m.slim", "--degree", "2", "--set", "angle=0", "--no-legend"});
    EXPECT_EQ(common.given,
              (std::vector<std::string>{"angle", "degree", "inputs", "legend", "output"}));
}

TEST(CommandLine, AConfigFileGivesItsKeysAndAPrintedOneThoseThatWereChangedInIt) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) /
                                       ("slim_config_" + std::to_string(getpid()) + ".toml");
    LineConfig usual, config;
    std::ofstream(file) << print_config(fields_of(usual)) << "\n";
    const std::vector<std::string> words = {"x.ply", "-o", "m.slim", "--config", file.string()};
    EXPECT_EQ(parse(config, words).given, (std::vector<std::string>{"inputs", "output"}));
    // Of a whole one what was changed in it, be it printed with a file to write or without.
    config = {};
    usual.angle = 3, usual.output = "other.slim";
    std::ofstream(file) << print_config(fields_of(usual)) << "\n";
    EXPECT_EQ(parse(config, words).given, (std::vector<std::string>{"angle", "inputs", "output"}));
    // Lines that were taken out make it no short one.
    config = {};
    std::string printed = print_config(fields_of(usual));
    for (const char* key : {"degree", "camera"}) {
        const std::size_t at = printed.find(std::string(key) + " = ");
        printed.erase(at, printed.find('\n', at) + 1 - at);
    }
    std::ofstream(file) << printed;
    EXPECT_EQ(parse(config, words).given, (std::vector<std::string>{"angle", "inputs", "output"}));
    EXPECT_EQ(config.degree, 2);
    // A short one means what it names, also as it is by default.
    config = {};
    std::ofstream(file) << "degree = 2\nangle = 3.0\nlegend = false\n";
    EXPECT_EQ(parse(config, words).given,
              (std::vector<std::string>{"angle", "degree", "inputs", "legend", "output"}));
    EXPECT_EQ(config.angle, 3);
    std::filesystem::remove(file);
}

TEST(CommandLine, AFlagIsOnOrOff) {
    LineConfig config;
    parse(config, {"x.ply", "-o", "m.slim", "--strict=true", "--legend=false"});
    EXPECT_TRUE(config.strict);
    EXPECT_FALSE(config.legend);
    for (const char* value : {"7", "-1", "on", "maybe"})
        EXPECT_EQ(refusal({"x.ply", "-o", "m.slim", std::string("--strict=") + value}),
                  std::string("--strict: expected true or false, found '") + value + "'");
}

TEST(CommandLine, WhatIsWrongWithOptionsOfEveryVerbBeginsWithTheirNames) {
    for (const char* n : {"0", "-1", "4097", "0x10", " 1", "1e1", "nan", "99999999999999999999"})
        EXPECT_EQ(refusal({"x.ply", "-o", "m.slim", std::string("--threads=") + n}),
                  std::string("--threads: expected a whole number from 1 to 4096, found '") + n +
                      "'");
    EXPECT_EQ(refusal({"x.ply", "-o", "m.slim", "--threads", "4096"}), "");
    EXPECT_EQ(refusal({"x.ply", "-o", "m.slim", "--config", "none.toml"}),
              "--config none.toml: cannot read: No such file or directory");
}

TEST(CommandLine, StandardOutputIsNoPlaceToWriteTo) {
    EXPECT_NE(refusal({"x.ply", "-o", "-"}).find("-o -: nothing is written to standard output"),
              std::string::npos);
    EXPECT_EQ(refusal({"x.ply", "-o", "./-"}), "");
}

TEST(CommandLine, OfAValueThatIsGivenAgainTheLastCounts) {
    LineConfig config;
    parse(config, {"x.ply", "-o", "m.slim", "--degree", "1", "--degree", "3", "--aov", "mean",
                   "--aov", "k1"});
    EXPECT_EQ(config.degree, 3);
    EXPECT_EQ(config.aov, (std::vector<std::string>{"mean", "k1"}));
}

TEST(CommandLine, ListsOfFilesAreWrittenWithCommasOrAgain) {
    LineConfig config;
    parse(config,
          {"x.ply", "-o", "m.slim", "--extra-path", "a.slim,b.slim", "--extra-path=c.slim"});
    EXPECT_EQ(config.extra, (std::vector<std::string>{"a.slim", "b.slim", "c.slim"}));
    // A file that has a comma in its name is one.
    const auto file =
        std::filesystem::temp_directory_path() / ("slim,comma" + std::to_string(getpid()));
    std::ofstream(file) << 'x';
    parse(config, {"x.ply", "-o", "m.slim", "--extra-path", file.string()});
    EXPECT_EQ(config.extra, std::vector<std::string>{file.string()});
    std::filesystem::remove(file);
}

TEST(CommandLine, ReadsWordsOptionsAndFlags) {
    LineConfig config;
    const CommonOptions common = parse(
        config, {"a.ply", "--degree", "3", "b.ply", "-o", "m.slim", "--no-legend", "--strict",
                 "--aov", "mean,k1", "--aov=k2", "--threads", "7", "-q", "--json", "--force"});
    EXPECT_EQ(config.inputs, (std::vector<std::string>{"a.ply", "b.ply"}));
    EXPECT_EQ(config.output, "m.slim");
    EXPECT_EQ(config.degree, 3);
    EXPECT_FALSE(config.legend);
    EXPECT_TRUE(config.strict);
    EXPECT_EQ(config.aov, (std::vector<std::string>{"mean", "k1", "k2"}));
    EXPECT_EQ(common.threads, 7);
    EXPECT_TRUE(common.quiet && common.json && common.force);
    EXPECT_FALSE(common.verbose || common.help || common.version || common.print_config);
}

TEST(CommandLine, NegativeNumbersAreValues) {
    LineConfig config;
    parse(config, {"--angle", "-30", "--camera", "-1,2,3"});
    EXPECT_EQ(config.angle, -30);
    EXPECT_EQ(config.camera, "-1,2,3");
}

TEST(CommandLine, WordsAreNotSplitAtCommas) {
    LineConfig config;
    parse(config, {"a,b.ply", "-o", "c,d.slim"});
    EXPECT_EQ(config.inputs, (std::vector<std::string>{"a,b.ply"}));
    EXPECT_EQ(config.output, "c,d.slim");
}

TEST(CommandLine, TheLaterOfFileSetAndOptionWins) {
    const std::filesystem::path file =
        std::filesystem::path(testing::TempDir()) / ("line_" + std::to_string(getpid()) + ".toml");
    std::ofstream(file) << "degree = 1\nangle = 10\ncamera = 'front'\n";
    LineConfig config;
    parse(config, {"--angle=30", "--set", "degree=2", "--set=angle=20", "--config", file.string()});
    EXPECT_EQ(config.camera, "front");
    EXPECT_EQ(config.degree, 2);
    EXPECT_EQ(config.angle, 30);
}

TEST(CommandLine, SuggestsTheNearestOption) {
    EXPECT_EQ(refusal({"--degre", "3"}), "--degre: unknown option (did you mean '--degree'?)");
    EXPECT_EQ(refusal({"-j", "3"}), "-j: unknown option (threads are --threads N)");
    EXPECT_EQ(refusal({"--view", "top"}), "--view: unknown option (did you mean '--camera'?)");
    EXPECT_EQ(refusal({"--input", "a.ply"}), "--input: unknown option (files to read are written "
                                             "without an option before them)");
    EXPECT_EQ(refusal({"--thread=3"}), "--thread: unknown option (did you mean '--threads'?)");
    EXPECT_EQ(refusal({"--set", "degre=3"}),
              "--set degre=3: unknown key 'degre' (did you mean 'degree'?)");
    EXPECT_NE(refusal({"--set", "qqqqqqqqqq=3"}).find("unknown key 'qqqqqqqqqq': expected one of "),
              std::string::npos);
}

TEST(CommandLine, RefusesWhatMakesNoSense) {
    EXPECT_NE(refusal({"--degree"}), "");
    EXPECT_NE(refusal({"--degree", "7"}), "");
    EXPECT_NE(refusal({"--set", "degree"}), "");
    EXPECT_NE(refusal({"--threads", "-1"}), "");
    EXPECT_NE(refusal({"--threads", "0"}).find("1 to "), std::string::npos)
        << refusal({"--threads", "0"});
    EXPECT_NE(refusal({"--threads", "many"}), "");
    EXPECT_NE(refusal({"-x"}), "");
}

TEST(CommandLine, SaysWhichOptionLacksItsValue) {
    EXPECT_EQ(refusal({"a.ply", "-o"}), "--output: a value is missing");
    EXPECT_EQ(refusal({"a.ply", "-o", "m.slim", "--degree"}), "--degree: a value is missing");
    EXPECT_EQ(refusal({"a.ply", "-o", "m.slim", "--threads"}), "--threads: a value is missing");
}

TEST(CommandLine, HelpNamesEveryFieldItsDefaultRangeAndExample) {
    LineConfig config;
    const std::string text =
        help_text({"line", "Draws a line.", {"slim line a.ply -o m.slim"}}, fields_of(config));
    for (const char* part : {"Draws a line.", "Usage: slim line INPUT... -o PATH", "--degree",
                             "in [1, 3]", "(default: 2)", "--no-legend", "--strict", "--extra-path",
                             "--threads", "slim line a.ply -o m.slim"})
        EXPECT_NE(text.find(part), std::string::npos) << part;
}

TEST(CommandLine, HelpOfASwitchSaysWhatTheSwitchDoes) {
    LineConfig config;
    const std::string text = help_text({"line", "Draws a line.", {}}, fields_of(config));
    EXPECT_NE(text.find("  --no-legend            turns off what is on by default: legend\n"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("  --strict               strict (default: off)\n"), std::string::npos)
        << text;
}

TEST(CommandLine, HelpIsAnsweredWhateverElseIsThere) {
    LineConfig config;
    EXPECT_TRUE(parse(config, {"--help", "--unknown"}).help);
    EXPECT_TRUE(parse(config, {"--version"}).version);
}

}  // namespace
}  // namespace slim
