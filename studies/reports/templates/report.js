// On a narrow screen each cell of a table stands on a line of its own, after the heading of its column.
function headings(table) {
  const labels = [];
  for (const row of table.tHead.rows) {
    let column = 0;
    for (const cell of row.cells)
      for (let repeat = 0; repeat < cell.colSpan; repeat++, column++)
        labels[column] = [labels[column], cell.textContent.trim()].filter(Boolean).join(": ");
  }
  return labels;
}
for (const table of document.querySelectorAll("table")) {
  if (!table.tHead) continue;
  const labels = headings(table);
  for (const row of table.tBodies[0].rows) {
    let column = 0;
    for (const cell of row.cells) {
      cell.dataset.label = labels[column] || "";
      column += cell.colSpan;
    }
  }
}

// A link to a part of the page unfolds it.
function unfold() {
  for (let each = document.getElementById(location.hash.slice(1)); each; each = each.parentElement)
    if (each.tagName === "DETAILS") each.open = true;
}
addEventListener("hashchange", unfold);
unfold();

// Paper cannot be opened: after the first sheet the parts are printed with laws and sources, and folded again.
const printed = () => document.querySelectorAll("details.section:not([open]), details.on-paper:not([open])");
let unfolded = [];
addEventListener("beforeprint", () => {
  unfolded = [...printed()];
  for (const each of unfolded) each.open = true;
});
addEventListener("afterprint", () => {
  for (const each of unfolded) each.open = false;
});
