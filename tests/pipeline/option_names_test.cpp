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

std::string said(Given given, const std::string& what) {
    return with_option_names(fields_of(given), what);
}

TEST(OptionNames, KeysOfOursAreOptions) {
    EXPECT_EQ(said({}, "degree: expected 1"), "--degree: expected 1");
    EXPECT_EQ(said({}, "say it with " + quoted_key("degree") + ", or " + quoted_key("output")),
              "say it with --degree, or --output");
    EXPECT_EQ(said({}, "the word " + quoted_key("model") + " and " + quoted_key("other")),
              "the word `model` and `other`");
}

TEST(OptionNames, WordsOfAFilesNameStayWhatTheyAre) {
    EXPECT_EQ(said({}, "a `degree` b.slim: is a folder"), "a `degree` b.slim: is a folder");
    EXPECT_EQ(said({}, "x`degree`.png: expected " + quoted_key("degree")),
              "x`degree`.png: expected --degree");
}

TEST(OptionNames, AFileHasItsOptionBeforeIt) {
    EXPECT_EQ(said({}, "out.png: expected .exr"), "-o out.png: expected .exr");
    EXPECT_EQ(said({}, "out.png:3: unknown key"), "out.png:3: unknown key");
    EXPECT_EQ(said({"m.slim"}, "m.slim: is a folder"), "m.slim: is a folder");
}

TEST(OptionNames, AJobsOwnOutputHasNoOption) {
    Given given;
    EXPECT_EQ(with_option_names(fields_of(given), "out.png: is a folder", true),
              "out.png: is a folder");
    EXPECT_EQ(with_option_names(fields_of(given), "degree: expected 1", true),
              "--degree: expected 1");
}

TEST(OptionNames, AFileThatIsCalledAsAnOptionBeginsAMessage) {
    EXPECT_EQ(said({"degree"}, "degree: is a cloud"), "degree: is a cloud");
    EXPECT_EQ(said({"degree 2.slim"}, "degree 2.slim: is a cloud"), "degree 2.slim: is a cloud");
    EXPECT_EQ(said({"other.slim"}, "degree: is too high"), "--degree: is too high");
    EXPECT_EQ(said({"deg"}, "degree: is too high"), "--degree: is too high");
}

}  // namespace
}  // namespace slim
