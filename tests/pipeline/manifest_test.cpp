#include "pipeline/manifest.h"

#include "pipeline/file_hash.h"
#include "pipeline/run_started.h"
#include "pipeline/stage.h"
#include "slim/base/error.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <map>
#include <string>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST(RunStarted, IsATimeOrNothing) {
    EXPECT_TRUE(is_utc_time("2026-11-28T11:20:05Z"));
    EXPECT_TRUE(is_utc_time(utc_now()));
    for (const char* other :
         {"", "junk", "2026-11-28", "2026-11-28T11:20:05", "2026-11-28T11:20:05Z ",
          " 2026-11-28T11:20:05Z", "2026-11-31T11:20:05Z", "2026-1-8T11:20:05Z",
          "2026-11-28T25:20:05Z", "2026-11-28T11:20:05ZZ"})
        EXPECT_FALSE(is_utc_time(other)) << other;
}

TEST(RunStarted, JunkInTheEnvironmentIsNoTime) {
    setenv("SLIM_RUN_STARTED", "junk", 1);  // looked at once in a process: here or before
    EXPECT_TRUE(is_utc_time(run_started())) << run_started();
    unsetenv("SLIM_RUN_STARTED");
}

class StampTest : public testing::Test {
public:
    void SetUp() override {
        folder_ =
            fs::path(testing::TempDir()) /
            ("stamp_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
        fs::remove_all(folder_);
        fs::create_directories(folder_);
        write("in.ply", "points");
    }

    void write(const std::string& name, const std::string& text) {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }

    StageContext context() { return {reporter_, 2, false, "fit", "degree = 2\n", "degree = 2\n"}; }

    /// One run of a stage: true if it was up to date, else it writes its output.
    bool run(const StageContext& with, const std::string& depends = "",
             const std::vector<std::string>& more = {}) {
        Stamp stamp(with, manifest_path(folder_ / "out.slim"));
        stamp.input(folder_ / "in.ply");
        stamp.optional_input(folder_ / "in.truth");
        stamp.depends(depends);
        stamp.outputs({folder_ / "out.slim"});
        for (const std::string& name : more) stamp.outputs({folder_ / name});
        if (const auto result = stamp.up_to_date()) {
            EXPECT_EQ(result->at("leaves"), 7);
            EXPECT_EQ(result->at("up_to_date"), true);
            EXPECT_TRUE(result->at("recorded").contains("seconds"));
            return true;
        }
        write("out.slim", "model");
        for (const std::string& name : more) write(name, "more");
        write("found.svg", "legend");
        EXPECT_EQ(stamp.commit({{"leaves", 7}}, Outlasts::power_cut, {folder_ / "found.svg"}),
                  (json{{"leaves", 7}}));
        return false;
    }

    Reporter reporter_;
    fs::path folder_;
};

TEST_F(StampTest, ASecondRunIsUpToDate) {
    EXPECT_FALSE(run(context()));
    EXPECT_TRUE(run(context()));
    EXPECT_TRUE(run(context()));
}

TEST_F(StampTest, AHashTakenInStepsIsThatOfTheFile) {
    std::string text(3000001, 'x');
    for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>(i * i >> 7);
    write("long", text);
    FileHash hash(folder_ / "long");
    for (const std::uint64_t end : {0u, 1u, 70000u, 1048577u, 60000u, 2500000u})
        hash.advance_to(end);
    const std::string found = hash.finish();
    EXPECT_EQ(found, hash_file(folder_ / "long"));
    EXPECT_EQ(found, hash_text(text));
    FileHash beyond(folder_ / "long");
    beyond.advance_to(5000000);
    EXPECT_EQ(beyond.finish(), found);
    EXPECT_THROW(FileHash(folder_ / "missing"), IoError);
}

TEST_F(StampTest, AKnownHashIsRecordedAndPassedOnInsteadOfReadingTheFile) {
    std::map<std::string, std::string> written;
    StageContext with = context();
    with.written = &written;
    Stamp stamp(with, manifest_path(folder_ / "out.slim"));
    stamp.input(folder_ / "in.ply");
    stamp.know_hash(folder_ / "in.ply", hash_text("as it was read"));
    write("out.slim", "model");
    stamp.outputs({folder_ / "out.slim"});
    stamp.commit({{"leaves", 7}});
    const json manifest = json::parse(std::ifstream(folder_ / "out.slim.done.json"));
    EXPECT_EQ(manifest.at("inputs").at(0).at("xxh3_128"), hash_text("as it was read"));
    EXPECT_EQ(written.at((folder_ / "in.ply").string()), hash_text("as it was read"));
}

TEST_F(StampTest, ThreadsDoNotMatter) {
    EXPECT_FALSE(run(context()));
    StageContext other = context();
    other.threads = 7;
    EXPECT_TRUE(run(other));
}

TEST_F(StampTest, WhatChangesTheResultIsDoneAgain) {
    const std::function<void(StampTest&, StageContext&)> changes[] = {
        [](StampTest& t, StageContext&) { t.write("in.ply", "Points"); },
        [](StampTest& t, StageContext&) { t.write("in.truth", "truth"); },
        [](StampTest& t, StageContext&) { t.write("out.slim", "MODEL"); },
        [](StampTest& t, StageContext&) { fs::remove(t.folder_ / "out.slim"); },
        [](StampTest& t, StageContext&) { fs::remove(t.folder_ / "found.svg"); },
        [](StampTest& t, StageContext&) { t.write("out.slim.done.json", "{\"stage\": \"fit\"}"); },
        [](StampTest& t, StageContext&) { t.write("out.slim.done.json", "not json"); },
        [](StampTest&, StageContext& c) { c.config = "degree = 3\n"; },
        [](StampTest&, StageContext& c) { c.stage = "tree"; },
        [](StampTest&, StageContext& c) { c.force = true; },
    };
    int i = 0;
    for (const auto& change : changes) {
        SCOPED_TRACE(i++);
        SetUp();
        StageContext with = context();
        EXPECT_FALSE(run(with));
        change(*this, with);
        EXPECT_FALSE(run(with));
    }
    SetUp();
    EXPECT_FALSE(run(context(), "slice 0"));
    EXPECT_FALSE(run(context(), "slice 1"));
}

TEST_F(StampTest, AFileThatIsAskedForAnewIsWritten) {
    EXPECT_FALSE(run(context(), "", {"a.ply"}));
    EXPECT_TRUE(run(context(), "", {"a.ply"}));
    EXPECT_FALSE(run(context(), "", {"b.ply"}));  // under another name
    EXPECT_TRUE(fs::exists(folder_ / "b.ply"));
    EXPECT_FALSE(run(context(), "", {"b.ply", "c.ply"}));
    EXPECT_TRUE(run(context(), "", {"c.ply"}));
}

TEST_F(StampTest, AFileThatIsNotAskedForAnyMoreIsOfNoConcern) {
    EXPECT_FALSE(run(context(), "", {"a.ply"}));
    fs::remove(folder_ / "a.ply");
    EXPECT_TRUE(run(context()));
    EXPECT_FALSE(run(context(), "", {"a.ply"}));
}

TEST_F(StampTest, ManifestsThatDoNotSayWhatWasAskedForAreRead) {
    EXPECT_FALSE(run(context()));
    const fs::path file = folder_ / "out.slim.done.json";
    json manifest = json::parse(std::ifstream(file));
    for (json& output : manifest.at("outputs")) output.erase("asked");
    std::ofstream(file) << manifest;
    EXPECT_TRUE(run(context()));
    manifest.at("outputs") = {{{"path", 3}}};
    std::ofstream(file) << manifest;
    EXPECT_FALSE(run(context()));
    manifest.erase("outputs");
    std::ofstream(file) << manifest;
    EXPECT_FALSE(run(context()));
}

TEST_F(StampTest, OnePathIsTheSameHoweverItIsWritten) {
    EXPECT_FALSE(run(context(), "", {"a.ply"}));
    EXPECT_TRUE(run(context(), "", {"./x/../a.ply"}));
}

TEST_F(StampTest, TheFolderMayMove) {
    EXPECT_FALSE(run(context()));
    const fs::path moved = folder_.string() + "_moved";
    fs::remove_all(moved);
    fs::rename(folder_, moved);
    folder_ = moved;
    EXPECT_TRUE(run(context()));
}

TEST_F(StampTest, TheManifestSaysWhatWasDone) {
    EXPECT_FALSE(run(context()));
    std::ifstream in(folder_ / "out.slim.done.json");
    const json manifest = json::parse(in);
    EXPECT_EQ(manifest.at("stage"), "fit");
    EXPECT_EQ(manifest.at("outputs")[0].at("path"), "out.slim");
    EXPECT_EQ(manifest.at("outputs")[0].at("bytes"), 5);
    EXPECT_EQ(manifest.at("inputs")[0].at("xxh3_128"), hash_file(folder_ / "in.ply"));
    EXPECT_EQ(manifest.at("threads"), 2);
    for (const char* key :
         {"program", "config", "config_hash", "seconds", "peak_memory_bytes", "host", "finished"})
        EXPECT_TRUE(manifest.contains(key)) << key;
}

TEST_F(StampTest, AMissingInputIsNamed) {
    const StageContext with = context();
    Stamp stamp(with, manifest_path(folder_ / "out.slim"));
    stamp.input(folder_ / "nowhere.ply");
    try {
        stamp.commit({});
        FAIL() << "no error";
    } catch (const IoError& error) {
        EXPECT_NE(std::string(error.what()).find("nowhere.ply"), std::string::npos);
        EXPECT_EQ(error.code(), ExitCode::bad_data);
    }
}

TEST(HashFile, IsTheHashOfTheBytes) {
    const fs::path file = fs::path(testing::TempDir()) / ("hash_me_" + std::to_string(getpid()));
    const std::string text(3'000'000, 'x');
    std::ofstream(file, std::ios::binary) << text;
    EXPECT_EQ(hash_file(file), hash_text(text));
    EXPECT_NE(hash_text("a"), hash_text("b"));
    EXPECT_EQ(hash_text("a").size(), 32u);
}

}  // namespace
}  // namespace slim
