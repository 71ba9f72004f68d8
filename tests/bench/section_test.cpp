#include "common/section.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/contains.hpp"

namespace tendril::bench {
namespace {

Section example() {
  Section section;
  section.name = "example";
  section.title = "Tables & <pages>";
  section.tables = {
      {"numbers",
       "Two rows",
       {"name", "count", "value"},
       {{std::string("a, \"b\""), std::int64_t{1234567}, 0.1}, {std::string("x|y"), std::int64_t{0}, std::nan("")}}}};
  section.left_out = {{"this", "because"}};
  return section;
}

TEST(Tables, AsCsvKeepAllDigitsAndQuoteWhatNeedsIt) {
  EXPECT_EQ(csv(example().tables[0]), "name,count,value\n\"a, \"\"b\"\"\",1234567,0.1\nx|y,0,nan\n");
}

TEST(Tables, AsMarkdownEscapeTheBarAndDashWhatIsNoNumber) {
  EXPECT_EQ(markdown(example().tables[0]),
            "| name | count | value |\n|---|---|---|\n| a, \"b\" | 1234567 | 0.1 |\n| x\\|y | 0 | - |\n");
}

TEST(Sections, AsPagesEscapeMarkup) {
  const std::string page = html(example(), {});
  EXPECT_TRUE(contains_text(page, "<h2>Tables &amp; &lt;pages&gt;</h2>"));
  EXPECT_TRUE(contains_text(page, "<td>a, &quot;b&quot;</td>"));
  EXPECT_TRUE(contains_text(page, "<li>this: because</li>"));
}

// RFC 4648, section 10.
TEST(Sections, AsPagesHoldTheirPictures) {
  Section section = example();
  section.figures = {{"figure", "caption", {}}};
  for (const auto& [bytes, letters] :
       {std::pair<std::string, std::string>{"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foobar", "Zm9vYmFy"}}) {
    EXPECT_TRUE(contains_text(html(section, {{"figure", bytes}}), "base64," + letters + "\"")) << bytes;
  }
}

TEST(Sections, AsJsonGiveNullForWhatIsNoNumber) {
  const std::string text = json(example());
  EXPECT_TRUE(contains_text(text, "null"));
  EXPECT_FALSE(contains_text(text, "nan"));
}

}  // namespace
}  // namespace tendril::bench
