#include "common/section.hpp"

#include <gtest/gtest.h>

#include <cmath>

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
  EXPECT_NE(page.find("<h2>Tables &amp; &lt;pages&gt;</h2>"), std::string::npos);
  EXPECT_NE(page.find("<td>a, &quot;b&quot;</td>"), std::string::npos);
  EXPECT_NE(page.find("<li>this: because</li>"), std::string::npos);
}

// RFC 4648, section 10.
TEST(Sections, AsPagesHoldTheirPictures) {
  Section section = example();
  section.figures = {{"figure", "caption", {}}};
  for (const auto& [bytes, letters] :
       {std::pair<std::string, std::string>{"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foobar", "Zm9vYmFy"}}) {
    EXPECT_NE(html(section, {{"figure", bytes}}).find("base64," + letters + "\""), std::string::npos) << bytes;
  }
}

TEST(Sections, AsJsonGiveNullForWhatIsNoNumber) {
  const std::string text = json(example());
  EXPECT_NE(text.find("null"), std::string::npos);
  EXPECT_EQ(text.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace tendril::bench
