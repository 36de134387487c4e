// Shows cost, set-up and findings of a form while it is written: asks for its page, and takes over what is beside it.
const form = document.querySelector("form.ask");
const look = form.querySelector(".look");
let waiting = 0;
let isAsking = false;

async function ask() {
  if (isAsking) return soon();
  isAsking = true;
  try {
    const body = new URLSearchParams(new FormData(form));
    const response = await fetch(form.action, { method: "POST", body, headers: { Accept: "text/html" } });
    const page = new DOMParser().parseFromString(await response.text(), "text/html");
    if (page.querySelector("#preview")) show(page);
    else document.querySelector("#preview").textContent = page.querySelector(".notice")?.textContent ?? page.title;
  } catch {
    document.querySelector("#preview").textContent = "The service does not answer.";
  } finally {
    isAsking = false;
  }
}

function show(page) {
  const runs = page.querySelector(".cost strong")?.textContent;
  document.querySelector(".ask [role=status]").textContent = runs ?? "Not yet a sweep";
  const opened = [...document.querySelectorAll("#elsewhere details")].map((each) => each.open);
  for (const id of ["preview", "elsewhere"])
    document.getElementById(id).replaceChildren(...page.getElementById(id).childNodes);
  document.querySelectorAll("#elsewhere details").forEach((each, place) => (each.open = opened[place] ?? each.open));
  for (const finding of form.querySelectorAll(".finding")) {
    const now = page.getElementById(finding.id);
    finding.replaceChildren(...(now?.childNodes ?? []));
    const field = document.getElementById(finding.id.replace("finding-", ""));
    if (now?.textContent) field.setAttribute("aria-invalid", "true");
    else field.removeAttribute("aria-invalid");
  }
  const names = "names-of-materials";
  document.getElementById(names).replaceChildren(...page.getElementById(names).childNodes);
}

function soon() {
  clearTimeout(waiting);
  waiting = setTimeout(ask, 400);
}

// The text of a file in UTF-16 with its mark, UTF-8, or Windows-1252, as whipple reads files.
function decoded(content) {
  const [first, second] = new Uint8Array(content);
  const mark = { "255,254": "utf-16le", "254,255": "utf-16be" }[`${first},${second}`];
  try {
    return new TextDecoder(mark ?? "utf-8", { fatal: true }).decode(content);
  } catch {
    return new TextDecoder("windows-1252").decode(content);
  }
}

look.hidden = true; // still the button of the Enter key, which so submits nothing
form.addEventListener("input", soon);
form.addEventListener("submit", (event) => {
  if (event.submitter?.value === "submit") return;
  event.preventDefault();
  ask();
});
for (const file of form.querySelectorAll("input[type=file]")) {
  file.hidden = false;
  file.addEventListener("change", async () => {
    document.getElementById(file.dataset.into).value = decoded(await file.files[0].arrayBuffer());
    soon();
  });
}
// A link to a field that is folded away opens its group.
form.addEventListener("click", (event) => {
  const link = event.target.closest("#preview a[href^='#']");
  const field = link && document.getElementById(link.getAttribute("href").slice(1));
  if (!field) return;
  event.preventDefault();
  field.closest("details").open = true;
  field.focus();
});
