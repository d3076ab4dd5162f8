(function () {
  "use strict";
  var flip = document.getElementById("flip");
  if (!flip) return;
  var figures = Array.from(flip.querySelectorAll("figure"));
  var bar = document.getElementById("flip-buttons");
  var at = 0;
  var buttons = figures.map(function (figure, i) {
    var button = document.createElement("button");
    button.type = "button";
    button.textContent = figure.dataset.label;
    button.addEventListener("click", function () { show(i); tell(); });
    bar.appendChild(button);
    return button;
  });
  function show(i) {
    at = (i + figures.length) % figures.length;
    figures.forEach(function (figure, j) {
      figure.classList.toggle("shown", j === at);
      buttons[j].setAttribute("aria-pressed", String(j === at));
    });
  }
  function tell() {
    try { history.replaceState(null, "", "#show=" + encodeURIComponent(figures[at].dataset.label)); } catch (e) { return; }
  }
  function read() {
    if (!location.hash.startsWith("#show=")) return;
    var label;
    try { label = decodeURIComponent(location.hash.slice(6)); } catch (e) { return; }
    var i = figures.findIndex(function (figure) { return figure.dataset.label === label; });
    if (i === -1) return;
    show(i);
    document.getElementById("pictures").scrollIntoView();
  }
  document.addEventListener("keydown", function (event) {
    if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return;
    if (event.target.closest(".scroll, .plot, pre")) return;
    var step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    show(at + step);
    tell();
    event.preventDefault();
  });
  flip.classList.add("on");
  bar.hidden = false;
  show(0);
  read();
  addEventListener("hashchange", read);
})();
