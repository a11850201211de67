for (const scene of document.querySelectorAll(".scene")) {
  const swipe = scene.querySelector(".swipe");
  if (!swipe) continue;
  const pictures = [...scene.querySelectorAll(".picture")];
  const stage = swipe.querySelector(".stage");
  const slider = swipe.querySelector("input");
  const [left, right] = swipe.querySelectorAll("select");
  const choose = (select, image, first) => {
    for (const picture of pictures) select.add(new Option(picture.dataset.name));
    select.selectedIndex = Math.min(first, pictures.length - 1);
    const show = () => { image.src = pictures[select.selectedIndex].src; };
    select.addEventListener("change", show);
    show();
  };
  choose(left, stage.querySelector(".over"), 1);
  choose(right, stage.querySelector("img"), 0);
  slider.addEventListener("input", () => stage.style.setProperty("--at", slider.value + "%"));
  stage.addEventListener("pointermove", (event) => {
    if (!event.buttons && event.pointerType === "mouse") return;
    const box = stage.getBoundingClientRect();
    slider.value = 100 * (event.clientX - box.left) / box.width;
    slider.dispatchEvent(new Event("input"));
  });
}
