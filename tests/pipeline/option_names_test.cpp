#include "pipeline/option_names.h"

#include <gtest/gtest.h>

namespace slim {
namespace {

struct Given {
    std::string model = {}, output = "out.png", degree = {};
    template <class V>
    void visit(V&& field) {
        field.input("model", model, "a model");
        field.output("output", output, "a picture");
        field("degree", degree, "a degree");
    }
};

std::string said(Given given, const Fault& fault, bool in_a_job = false) {
    return message_of(with_option_names(fields_of(given), fault, in_a_job));
}

TEST(OptionNames, KeysOfOursAreOptions) {
    EXPECT_EQ(said({}, {.key = "degree", .expected = "1"}), "--degree: expected 1");
    EXPECT_EQ(said({}, {.key = "degree", .problem = " and more"}), "--degree and more");
    EXPECT_EQ(said({}, {.key = "model", .problem = "is none"}), "model: is none");
    EXPECT_EQ(said({}, {.problem = "say it with " + quoted_key("degree") + ", or " +
                                   quoted_key("output")}),
              "say it with --degree, or --output");
    EXPECT_EQ(said({}, {.problem = "the word " + quoted_key("model") + " and " +
                                   quoted_key("other")}),
              "the word `model` and `other`");
}

TEST(OptionNames, KeysInAFileStayKeys) {
    EXPECT_EQ(said({}, {.file = "job.toml", .line = 3, .key = "degree", .expected = "1"}),
              "job.toml:3: degree: expected 1");
    EXPECT_EQ(said({}, {.file = "job.toml", .said_by = "--set", .key = "degree", .expected = "1"}),
              "job.toml, --set: degree: expected 1");
}

TEST(OptionNames, WordsOfAUsersTextStayWhatTheyAre) {
    EXPECT_EQ(said({}, {.file = "a `degree` b.slim", .problem = "is a folder"}),
              "a `degree` b.slim: is a folder");
    EXPECT_EQ(said({}, {.problem = "degree: of a text"}), "degree: of a text");
}

TEST(OptionNames, AFileHasItsOptionBeforeIt) {
    EXPECT_EQ(said({}, {.file = "out.png", .expected = ".exr"}), "-o out.png: expected .exr");
    EXPECT_EQ(said({}, {.file = "out.png", .line = 3, .problem = "unknown key"}),
              "out.png:3: unknown key");
    EXPECT_EQ(said({"m.slim"}, {.file = "m.slim", .problem = "is a folder"}),
              "m.slim: is a folder");
}

TEST(OptionNames, AJobsOwnOutputHasNoOption) {
    EXPECT_EQ(said({}, {.file = "out.png", .problem = "is a folder"}, true),
              "out.png: is a folder");
    EXPECT_EQ(said({}, {.key = "degree", .expected = "1"}, true), "--degree: expected 1");
}

}  // namespace
}  // namespace slim
