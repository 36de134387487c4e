// Search of the pages, in place of that of mkdocs, whose worker and fetch a browser refuses to a page from disk:
// the index is a script, and is loaded when the search is first used.
document.addEventListener("DOMContentLoaded", () => {
  const query = document.getElementById("mkdocs-search-query");
  const results = document.getElementById("mkdocs-search-results");
  let ready;

  function load(file) {
    return new Promise((done, failed) => {
      const script = document.createElement("script");
      Object.assign(script, { src: `${base_url}/search/${file}`, onload: done, onerror: failed });
      document.head.append(script);
    });
  }

  async function prepare() {
    await load("lunr.js");
    await load("search_index.js");
    const pages = new Map(search_index.docs.map((page) => [page.location, page]));
    const index = lunr(function () {
      this.field("title", { boost: 10 });
      this.field("text");
      this.ref("location");
      pages.forEach((page) => this.add(page));
    });
    // With all of the words, else with any of them.
    return (words) => {
      const all = index.search(words.map((word) => `+${word}`).join(" "));
      return (all.length ? all : index.search(words.join(" "))).map((found) => pages.get(found.ref));
    };
  }

  function shown(page) {
    const article = document.createElement("article");
    const link = Object.assign(document.createElement("a"), { href: `${base_url}/${page.location}`, textContent: page.title });
    const text = Object.assign(document.createElement("p"), { textContent: page.text.slice(0, 200) });
    article.append(link, text);
    return article;
  }

  query.form.addEventListener("submit", (event) => event.preventDefault());
  query.addEventListener("input", async () => {
    ready ??= prepare();
    const search = await ready;
    const words = query.value.match(/[\p{L}\p{N}.]{2,}/gu) ?? [];
    const pages = words.length ? search(words) : [];
    results.replaceChildren(...pages.slice(0, 30).map(shown));
    if (words.length && !pages.length) results.textContent = results.dataset.noResultsText;
  });
});
